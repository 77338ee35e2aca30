#include "reference/sphere.hpp"

#include <algorithm>
#include <cmath>

namespace raig::reference {

namespace {

__extension__ typedef __float128 Quad;

double rootOf(double x) {
    return std::sqrt(x);
}

/// One step of Newton's from double's root doubles its bits.
Quad rootOf(Quad x) {
    if (x <= 0) return 0;
    const Quad guess = std::sqrt(static_cast<double>(x));
    return guess > 0 ? (guess + x / guess) / 2 : guess;
}

/// a t^2 + 2 b t + c = 0 at the surface.
template <class Real>
struct Quadratic {
    Real a = 0, b = 0, c = 0;

    Quadratic(const Ray& ray, const vec3& centre, float radius) {
        for (int axis = 0; axis < 3; ++axis) {
            const Real d = ray.direction[axis], f = Real(ray.origin[axis]) - Real(centre[axis]);
            a += d * d;
            b += d * f;
            c += f * f;
        }
        c -= Real(radius) * Real(radius);
    }
    Real discriminant() const { return b * b - a * c; }
    std::optional<SphereCrossing> crossing() const {
        const Real rest = discriminant();
        if (rest < 0) return std::nullopt;
        const Real root = rootOf(rest);
        return SphereCrossing{static_cast<double>((-b - root) / a), static_cast<double>((-b + root) / a)};
    }
};

}  // namespace

std::optional<SphereCrossing> crossSphere(const Ray& ray, const vec3& centre, float radius) {
    const Quadratic<double> plain(ray, centre, radius);
    // Of both differences, b b - a c and c itself, little may cancel.
    const double rest = plain.discriminant(), squared = plain.c + 2.0 * double{radius} * radius;
    const bool clear =
        std::abs(rest) > 0x1p-20 * (plain.b * plain.b + plain.a * squared) && std::abs(plain.c) > 0x1p-20 * squared;
    return clear ? plain.crossing() : Quadratic<Quad>(ray, centre, radius).crossing();
}

Approach approachSphere(const Ray& ray, const vec3& centre, float radius) {
    Approach nearest{std::numeric_limits<double>::infinity(), ray.tMin};
    const auto consider = [&](double t) {
        if (!std::isfinite(t) || t < ray.tMin || t > ray.tMax) return;
        const double distance = distanceToSphere(ray.origin + t * ray.direction, centre, radius);
        if (distance < nearest.distance) nearest = {distance, t};
    };
    if (const auto crossing = crossSphere(ray, centre, radius))
        for (const double t : {crossing->near, crossing->far})
            if (t >= ray.tMin && t <= ray.tMax) return {0.0, t};
    const double along = glm::dot(dvec3(centre) - ray.origin, ray.direction) / glm::dot(ray.direction, ray.direction);
    for (const double t : {ray.tMin, ray.tMax, along}) consider(t);
    return nearest;
}

double distanceToSphere(const dvec3& point, const vec3& centre, float radius) {
    return std::abs(glm::length(point - dvec3(centre)) - double{radius});
}

}  // namespace raig::reference

#include "structures/bvh_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig::bvh {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double margin = 0x1p-44;  // more than sums of three products of numbers up to 2 are rounded by, in double

float roundedDown(double x) {
    const auto f = static_cast<float>(x);
    return f > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float roundedUp(double x) {
    const auto f = static_cast<float>(x);
    return f < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

double diagonal(const std::array<int, 3>& signs, const vec3& p) {
    return signs[0] * double{p.x} + signs[1] * double{p.y} + signs[2] * double{p.z};
}

/// The extent of a ball along an axis, to some roundings of numbers up to 2: `least` is rounded down in no way.
struct Extent {
    double least, most;
};

Extent extentAlong(const vec3& axis, const Ball& ball) {
    const double at = glm::dot(dvec3(axis), dvec3(ball.centre)), reach = ball.radius * glm::length(dvec3(axis));
    return {at - reach, at + reach};
}

/// As Kdop's slabs lie. Sums of three floats of a scene's extent are nearly always exact; what a ball's radius adds is not.
Extent extentAlong(int slab, const Ball& ball) {
    const double at = slab < 3 ? double{ball.centre[slab]} : diagonal(diagonals[slab - 3], ball.centre);
    if (ball.radius == 0.0f) return {at, at};
    const double reach = ball.radius * (slab < 3 ? 1.0 : std::sqrt(3.0)) + margin;
    return {at - reach, at + reach};
}

OrientedBox boxAlong(const std::array<vec3, 3>& axes, std::span<const Ball> balls) {
    OrientedBox box{axes, vec3(0.0f), vec3(0.0f)};
    for (int i = 0; i < 3; ++i) {
        double lo = infinity, hi = -infinity;
        for (const Ball& ball : balls) {
            const Extent along = extentAlong(axes[i], ball);
            lo = std::min(lo, along.least);
            hi = std::max(hi, along.most);
        }
        box.lo[i] = roundedDown(lo - margin);
        box.hi[i] = roundedUp(hi + margin);
    }
    return box;
}

float halfArea(const OrientedBox& box) {
    const vec3 e = box.hi - box.lo;
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

/// Eigenvectors of a symmetric matrix, by Jacobi's rotations.
std::array<dvec3, 3> eigenvectors(double (&m)[3][3]) {
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (m[p][q] == 0.0) continue;
                const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - s * b;
                    m[k][q] = s * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = m[p][k], b = m[q][k];
                    m[p][k] = c * a - s * b;
                    m[q][k] = s * a + c * b;
                }
                for (auto& row : v) {
                    const double a = row[p], b = row[q];
                    row[p] = c * a - s * b;
                    row[q] = s * a + c * b;
                }
            }
    std::array<dvec3, 3> result;
    for (int i = 0; i < 3; ++i) result[i] = dvec3(v[0][i], v[1][i], v[2][i]);
    return result;
}

std::array<vec3, 3> principalAxes(std::span<const Ball> balls) {
    dvec3 mean(0.0);
    for (const Ball& ball : balls) mean += dvec3(ball.centre) / static_cast<double>(balls.size());
    double covariance[3][3] = {};
    for (const Ball& ball : balls) {
        const dvec3 d = dvec3(ball.centre) - mean;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) covariance[i][j] += d[i] * d[j];
    }
    const std::array<dvec3, 3> found = eigenvectors(covariance);
    return {vec3(found[0]), vec3(found[1]), vec3(found[2])};
}

}  // namespace

Sphere sphereAround(std::span<const Ball> balls) {
    const auto reachFrom = [](const dvec3& centre, const Ball& ball) {
        const dvec3 d = dvec3(ball.centre) - centre;
        return std::sqrt(glm::dot(d, d)) + ball.radius;
    };
    const auto farthestFrom = [&](const dvec3& centre) {
        size_t farthest = 0;
        double most = -1.0;
        for (size_t i = 0; i < balls.size(); ++i) {
            const double reach = reachFrom(centre, balls[i]);
            if (reach > most) {
                most = reach;
                farthest = i;
            }
        }
        return farthest;
    };
    dvec3 centre(balls[0].centre);
    const int steps = static_cast<int>(std::clamp<size_t>((1u << 20) / balls.size(), 8, 64));
    for (int i = 1; i <= steps; ++i) {
        const Ball& ball = balls[farthestFrom(centre)];
        const dvec3 d = dvec3(ball.centre) - centre;
        const double length = std::sqrt(glm::dot(d, d));
        // Towards the farthest point of the ball.
        if (length > 0.0) centre += d * ((length + ball.radius) / length / (i + 1.0));
    }
    const vec3 rounded(centre);
    return {rounded, roundedUp(reachFrom(dvec3(rounded), balls[farthestFrom(dvec3(rounded))]) + margin)};
}

OrientedBox orientedBoxAround(std::span<const Ball> balls) {
    const OrientedBox straight = boxAlong({vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)}, balls);
    const OrientedBox turned = boxAlong(principalAxes(balls), balls);
    return halfArea(turned) < halfArea(straight) ? turned : straight;
}

Kdop kdopAround(std::span<const Ball> balls) {
    Kdop kdop;
    for (int slab = 0; slab < Kdop::slabs; ++slab) {
        double lo = infinity, hi = -infinity;
        for (const Ball& ball : balls) {
            const Extent along = extentAlong(slab, ball);
            lo = std::min(lo, along.least);
            hi = std::max(hi, along.most);
        }
        kdop.lo[slab] = roundedDown(lo);
        kdop.hi[slab] = roundedUp(hi);
    }
    return kdop;
}

bool contains(const Sphere& sphere, const Ball& ball) {
    const dvec3 d = dvec3(ball.centre) - dvec3(sphere.centre);
    return std::sqrt(glm::dot(d, d)) + ball.radius <= double{sphere.radius} + margin;
}

bool contains(const OrientedBox& box, const Ball& ball) {
    for (int i = 0; i < 3; ++i) {
        const Extent along = extentAlong(box.axes[i], ball);
        if (!(along.least >= box.lo[i] - margin && along.most <= box.hi[i] + margin)) return false;
    }
    return true;
}

bool contains(const Kdop& kdop, const Ball& ball) {
    for (int slab = 0; slab < Kdop::slabs; ++slab) {
        const Extent along = extentAlong(slab, ball);
        if (!(along.least >= kdop.lo[slab] && along.most <= kdop.hi[slab])) return false;
    }
    return true;
}

}  // namespace raig::bvh

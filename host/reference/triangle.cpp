#include "reference/triangle.hpp"

#include <algorithm>
#include <cmath>

namespace raig::reference {

namespace {

__extension__ typedef __float128 Quad;

template <class Real>
struct Vector {
    Real x, y, z;
    explicit Vector(const dvec3& v) : x(v.x), y(v.y), z(v.z) {}
    Vector(Real x_, Real y_, Real z_) : x(x_), y(y_), z(z_) {}
};

template <class Real>
Vector<Real> operator-(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <class Real>
Real dot(const Vector<Real>& a, const Vector<Real>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Exactly antisymmetric, rounding included: cross(a, b) == -cross(b, a). So the two triangles at an edge agree about it.
template <class Real>
Vector<Real> cross(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double magnitude(const dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The signed volumes of the ray with the triangle's edges, and the two sides of the plane's equation.
template <class Real>
struct Volumes {
    Real a, b, c;           ///< six times; all of one sign where the line crosses the triangle
    Real height, approach;  ///< t = height / approach

    Volumes(const Ray& ray, const vec3& cornerA, const vec3& cornerB, const vec3& cornerC)
        : Volumes(Vector<Real>(ray.origin), Vector<Real>(ray.direction), Vector<Real>(dvec3(cornerA)),
                  Vector<Real>(dvec3(cornerB)), Vector<Real>(dvec3(cornerC))) {}

    Volumes(const Vector<Real>& o, const Vector<Real>& d, const Vector<Real>& pa, const Vector<Real>& pb,
            const Vector<Real>& pc) {
        const Vector<Real> ra = pa - o, rb = pb - o, rc = pc - o;
        a = dot(d, cross(rb, rc));
        b = dot(d, cross(rc, ra));
        c = dot(d, cross(ra, rb));
        const Vector<Real> normal = cross(pb - pa, pc - pa);
        height = dot(normal, ra);
        approach = dot(normal, d);
    }

    std::optional<Crossing> crossing() const {
        const bool front = a >= 0 && b >= 0 && c >= 0;
        const bool back = a <= 0 && b <= 0 && c <= 0;
        if (!(front || back) || approach == 0) return std::nullopt;
        const Real sum = a + b + c;
        if (sum == 0) return std::nullopt;
        return Crossing{static_cast<double>(height / approach), static_cast<double>(b / sum), static_cast<double>(c / sum)};
    }
};

/// True where rounding in double may have changed a sign that matters, or spoilt t. A volume is a sum of 6 products of 3
/// numbers that each err by 2^-53: 2^-46 of the products' largest value is more than 8 times its error.
bool isInDoubt(const Volumes<double>& v, const Ray& ray, const dvec3& a, const dvec3& b, const dvec3& c) {
    const double d = magnitude(ray.direction);
    const double ra = magnitude(a - ray.origin), rb = magnitude(b - ray.origin), rc = magnitude(c - ray.origin);
    constexpr double slack = 0x1p-46;
    const double slackA = slack * d * rb * rc, slackB = slack * d * rc * ra, slackC = slack * d * ra * rb;
    // Clearly on different sides of two edges: no crossing, and no doubt.
    if ((v.a > slackA || v.b > slackB || v.c > slackC) && (v.a < -slackA || v.b < -slackB || v.c < -slackC)) return false;
    if (std::abs(v.a) <= slackA || std::abs(v.b) <= slackB || std::abs(v.c) <= slackC) return true;
    return std::abs(v.approach) <= 0x1p-20 * d * magnitude(b - a) * magnitude(c - a);
}

dvec3 at(const Ray& ray, double t) {
    return ray.origin + t * ray.direction;
}

/// The nearest points of the ray and the segment from p to q.
/// Source: Ericson 2005, "Real-Time Collision Detection", section 5.1.9 (two segments), the ray's end being clamped first.
Approach approachSegment(const Ray& ray, const dvec3& p, const dvec3& q) {
    const dvec3 d = ray.direction, e = q - p, r = ray.origin - p;
    const double dd = glm::dot(d, d), de = glm::dot(d, e), ee = glm::dot(e, e);
    const double dr = glm::dot(d, r), er = glm::dot(e, r);
    const double determinant = dd * ee - de * de;
    const auto clampT = [&](double t) { return std::clamp(t, ray.tMin, ray.tMax); };
    double t = determinant > 0.0 ? clampT((de * er - ee * dr) / determinant) : clampT(-dr / dd);
    const double s = ee > 0.0 ? std::clamp((de * t + er) / ee, 0.0, 1.0) : 0.0;
    t = clampT((de * s - dr) / dd);
    return {glm::length(at(ray, t) - (p + s * e)), t};
}

dvec3 nearestOnTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 ab = b - a, ac = c - a;
    const double a1 = glm::dot(ab, p - a), a2 = glm::dot(ac, p - a);
    if (a1 <= 0.0 && a2 <= 0.0) return a;
    const double b1 = glm::dot(ab, p - b), b2 = glm::dot(ac, p - b);
    if (b1 >= 0.0 && b2 <= b1) return b;
    const double vc = a1 * b2 - b1 * a2;
    if (vc <= 0.0 && a1 >= 0.0 && b1 <= 0.0) return a + a1 / (a1 - b1) * ab;
    const double c1 = glm::dot(ab, p - c), c2 = glm::dot(ac, p - c);
    if (c2 >= 0.0 && c1 <= c2) return c;
    const double vb = c1 * a2 - a1 * c2;
    if (vb <= 0.0 && a2 >= 0.0 && c2 <= 0.0) return a + a2 / (a2 - c2) * ac;
    const double va = b1 * c2 - c1 * b2;
    if (va <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0) return b + (b2 - b1) / ((b2 - b1) + (c1 - c2)) * (c - b);
    const double sum = va + vb + vc;
    return a + vb / sum * ab + vc / sum * ac;
}

}  // namespace

bool isUsable(const Ray& ray) {
    const auto finite = [](const dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    return finite(ray.origin) && finite(ray.direction) && std::isfinite(ray.tMin) && ray.tMin <= ray.tMax &&
           ray.direction != dvec3(0.0);
}

std::optional<Crossing> cross(const Ray& ray, const vec3& a, const vec3& b, const vec3& c) {
    const Volumes<double> volumes(ray, a, b, c);
    if (isInDoubt(volumes, ray, a, b, c)) return Volumes<Quad>(ray, a, b, c).crossing();
    return volumes.crossing();
}

Approach approach(const Ray& ray, const vec3& a, const vec3& b, const vec3& c) {
    const std::optional<Crossing> crossing = cross(ray, a, b, c);
    if (crossing && crossing->t >= ray.tMin && crossing->t <= ray.tMax) return {0.0, crossing->t};
    Approach nearest = approachSegment(ray, a, b);
    for (const Approach& other : {approachSegment(ray, b, c), approachSegment(ray, c, a)})
        if (other.distance < nearest.distance) nearest = other;
    // The ray's ends may be nearest to the triangle's inside.
    for (const double t : {ray.tMin, ray.tMax}) {
        if (!std::isfinite(t)) continue;
        const double distance = distanceToTriangle(at(ray, t), a, b, c);
        if (distance < nearest.distance) nearest = {distance, t};
    }
    return nearest;
}

double distanceToTriangle(const dvec3& point, const vec3& a, const vec3& b, const vec3& c) {
    return glm::length(point - nearestOnTriangle(point, a, b, c));
}

}  // namespace raig::reference

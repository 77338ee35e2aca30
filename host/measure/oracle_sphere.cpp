// The oracle's half for spheres.
#include "measure/oracle_parts.hpp"

#include <algorithm>

namespace raig::hard {

namespace {

/// The square root, by Newton's method from that of doubles: to the last of 113 bits, but for one.
Exact rootOf(Exact square) {
    const double start = std::sqrt(double(square));
    if (!(start > 0.0)) return 0;
    Exact root = start;
    for (int i = 0; i < 2; ++i) root = (root + square / root) / 2;
    return root;
}

}  // namespace

bool isSoundSphere(const Primitive& sphere) {
    if (!(sphere.radius() > 0.0f) || !isWithin(sphere.centre(), farthestCorner)) return false;
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(double{sphere.centre()[axis]}) + double{sphere.radius()} > farthestCorner) return false;
    return true;
}

/// Of the sphere, its radius larger by `margin`.
Oracle::Crossing Oracle::cross(const Seen& s, const Primitive& sphere, double margin) const {
    const Exact r = Exact(sphere.radius()) + Exact(margin);
    Exact a = 0, b = 0, ff = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const Exact f = Exact(s.ray.origin[axis]) - Exact(sphere.centre()[axis]), d = s.ray.direction[axis];
        a += d * d;
        b -= f * d;
        ff += f * f;
    }
    const Exact power = certain(ff - r * r, ff + r * r), rest = certain(b * b - a * power, b * b + a * (ff + r * r));
    Crossing c;
    c.nearest = double(b / a);
    c.off = std::sqrt(std::max(0.0, double(ff - b * b / a))) - double(r);
    c.meets = rest >= 0 && r >= 0;
    if (!c.meets) return c;
    const Exact root = rootOf(rest), q = b < 0 ? b - root : b + root;
    const Exact one = q / a, other = q == 0 ? Exact(0) : Exact(power / q);
    c.first = one < other ? one : other;
    c.second = one < other ? other : one;
    return c;
}

/// How far the ray's point at the sphere may be moved along it, and remain within what rounding explains of the surface.
double Oracle::giveOf(const Seen& s, const Primitive& sphere, Exact t) const {
    const double slack = std::sqrt(3.0) * ofHit * s.unit;
    const Crossing inner = cross(s, sphere, -slack), outer = cross(s, sphere, slack);
    double give = 0.0;
    const auto reach = [&](Exact end) { give = std::max(give, std::abs(double(end - t))); };
    if (!outer.meets) return give;
    // The shell between both is passed twice, or once where the inner sphere is not met.
    const bool isFirst = inner.meets && t <= inner.first, isSecond = inner.meets && t >= inner.second;
    if (!isSecond) reach(outer.first);
    if (!isFirst) reach(outer.second);
    if (isFirst) reach(inner.first);
    if (isSecond) reach(inner.second);
    return give;
}

/// The first point in [tMin, tMax], or else the second.
Oracle::Meeting Oracle::meetSphere(const Seen& s, const Primitive& sphere) const {
    const Crossing c = cross(s, sphere, 0.0);
    Meeting m;
    m.hits = c.meets;
    if (!c.meets) return m;
    m.t = c.first >= Exact(s.ray.tMin) ? c.first : c.second;
    m.give = giveOf(s, sphere, m.t);
    return m;
}

}  // namespace raig::hard

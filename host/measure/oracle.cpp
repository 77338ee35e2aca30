#include "measure/oracle_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace raig::hard {

namespace {

/// a . (b x c), and the sum of the magnitudes of its terms.
template <class Vector>
Exact tripleProduct(const Vector& a, const Vector& b, const Vector& c) {
    const Exact terms[6] = {a.x * b.y * c.z,  -a.x * b.z * c.y, a.y * b.z * c.x,
                            -a.y * b.x * c.z, a.z * b.x * c.y,  -a.z * b.y * c.x};
    Exact sum = 0, size = 0;
    for (const Exact term : terms) {
        sum += term;
        size += magnitude(term);
    }
    return certain(sum, size);
}

bool hasArea(const Triangle& t) {
    const Exact ab[3] = {Exact(t.b.x) - t.a.x, Exact(t.b.y) - t.a.y, Exact(t.b.z) - t.a.z};
    const Exact ac[3] = {Exact(t.c.x) - t.a.x, Exact(t.c.y) - t.a.y, Exact(t.c.z) - t.a.z};
    return ab[1] * ac[2] != ab[2] * ac[1] || ab[2] * ac[0] != ab[0] * ac[2] || ab[0] * ac[1] != ab[1] * ac[0];
}

double smallestOf(double a, double b, double c) {
    return std::min(a, std::min(b, c));
}

/// The distance of a point from a triangle. Source: Ericson 2005, "Real-Time Collision Detection", 5.1.5.
double distanceTo(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const auto toSegment = [&](const dvec3& from, const dvec3& to) {
        const dvec3 along = to - from;
        const double f = glm::dot(p - from, along) / glm::dot(along, along);
        return glm::length(p - from - std::clamp(f, 0.0, 1.0) * along);
    };
    const dvec3 n = glm::cross(b - a, c - a);
    const double edge = smallestOf(toSegment(a, b), toSegment(b, c), toSegment(c, a));
    const bool inside = glm::dot(n, glm::cross(b - a, p - a)) >= 0.0 && glm::dot(n, glm::cross(c - b, p - b)) >= 0.0 &&
                        glm::dot(n, glm::cross(a - c, p - c)) >= 0.0;
    const double size = glm::length(n);
    return inside && size > 0.0 ? std::min(edge, std::abs(glm::dot(p - a, n)) / size) : edge;
}

}  // namespace

std::string describe(const Ray& r) {
    return fmt::format("o ({:.9g}, {:.9g}, {:.9g}) d ({:.9g}, {:.9g}, {:.9g}) t [{:.9g}, {:.9g}]", r.origin.x, r.origin.y,
                       r.origin.z, r.direction.x, r.direction.y, r.direction.z, r.tMin, r.tMax);
}

std::string describe(const Hit& h) {
    if (h.primitive == NO_HIT) return "nothing";
    return fmt::format("primitive {} t {:.9g} u {:.9g} v {:.9g}", h.primitive, h.t, h.u, h.v);
}

Oracle::Oracle(std::span<const Primitive> primitives) : primitives_(primitives.begin(), primitives.end()) {
    const auto before = [](const vec3& a, const vec3& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    std::map<vec3, uint32_t, decltype(before)> numbers(before);
    std::map<std::array<uint32_t, 2>, uint32_t> edges;
    for (const Primitive& t : primitives_) {
        if (t.isSphere()) {
            usable_.push_back(isSoundSphere(t));
            if (usable_.back() != 0) bounds_.grow(t.box());
            continue;
        }
        const bool isFinite =
            isWithin(t.a, farthestCorner) && isWithin(t.b, farthestCorner) && isWithin(t.c, farthestCorner);
        usable_.push_back(isFinite && hasArea(t));
        if (usable_.back() == 0) continue;
        bounds_.grow(t.box());
        std::array<uint32_t, 3> corners{};
        const std::array<vec3, 3> places{t.a, t.b, t.c};
        for (size_t i = 0; i < 3; ++i) {
            const auto [at, isNew] = numbers.insert({places[i], static_cast<uint32_t>(corners_.size())});
            if (isNew) corners_.push_back(places[i]);
            corners[i] = at->second;
        }
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t from = corners[i], to = corners[(i + 1) % 3];
            const std::array<uint32_t, 2> key{std::min(from, to), std::max(from, to)};
            const auto [at, isNew] = edges.insert({key, static_cast<uint32_t>(edges_.size())});
            if (isNew) edges_.push_back({key[0], key[1], {}});
            edges_[at->second].across.push_back(corners[(i + 2) % 3]);
        }
    }
}

Oracle::Seen Oracle::seen(const Ray& ray) const {
    Seen s{.ray = ray};
    const vec3 d = ray.direction;
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(double{d[axis]}) > largest) {
            largest = std::abs(double{d[axis]});
            s.z = axis;
        }
    // Directions of denormals only are none: devices may take them for zeros.
    s.valid = isWithin(ray.origin, farthestCorner) && isFinite(d) && largest >= 0x1p-126 && ray.tMax >= 0.0f &&
              ray.tMin <= ray.tMax;
    if (!s.valid) return s;
    s.ray.tMin = std::max(ray.tMin, 0.0f);
    s.scale = std::ldexp(1.0, -std::ilogb(largest));
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {bounds_.lo[axis], bounds_.hi[axis]})
            s.unit = std::max(s.unit, roundoff * std::abs(double{side} - double{ray.origin[axis]}));
    return s;
}

/// False only if the ray certainly misses the triangle: in double precision, with the error of each edge function bounded by
/// its terms. Products of three floats neither overflow nor underflow in doubles.
bool Oracle::mayMeet(const Seen& s, const Primitive& t) const {
    const dvec3 d(s.ray.direction), o(s.ray.origin);
    if (t.isSphere()) {
        const dvec3 f = o - dvec3(t.centre());
        const double along = glm::dot(f, d), dd = glm::dot(d, d), ff = glm::dot(f, f), rr = double{t.radius()} * t.radius();
        return along * along - dd * (ff - rr) >= -0x1p-46 * dd * (ff + rr);
    }
    const dvec3 a = dvec3(t.a) - o, b = dvec3(t.b) - o, c = dvec3(t.c) - o;
    const auto size = [](const dvec3& v) { return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z))); };
    const double most = std::max(size(a), std::max(size(b), size(c))) + size(o);
    const double error = 0x1p-46 * size(d) * most * most;
    const double edges[3] = {glm::dot(d, glm::cross(b, c)), glm::dot(d, glm::cross(c, a)), glm::dot(d, glm::cross(a, b))};
    const bool below = edges[0] < -error || edges[1] < -error || edges[2] < -error;
    const bool above = edges[0] > error || edges[1] > error || edges[2] > error;
    return !(below && above);
}

Oracle::Meeting Oracle::meet(const Seen& s, const Primitive& primitive) const {
    return primitive.isSphere() ? meetSphere(s, primitive) : meetTriangle(s, primitive);
}

Oracle::Meeting Oracle::meetTriangle(const Seen& s, const Triangle& t) const {
    const auto from = [&](const vec3& corner) {
        return Vector{Exact(corner.x) - Exact(s.ray.origin.x), Exact(corner.y) - Exact(s.ray.origin.y),
                      Exact(corner.z) - Exact(s.ray.origin.z)};
    };
    const Vector a = from(t.a), b = from(t.b), c = from(t.c);
    const Vector d{Exact(s.ray.direction.x), Exact(s.ray.direction.y), Exact(s.ray.direction.z)};
    const Vector ab{b.x - a.x, b.y - a.y, b.z - a.z}, ac{c.x - a.x, c.y - a.y, c.z - a.z};
    const Exact edgeA = tripleProduct(d, b, c), edgeB = tripleProduct(d, c, a), edgeC = tripleProduct(d, a, b);
    const Exact all = tripleProduct(d, ab, ac);
    Meeting m;
    if (all == 0) return m;
    const bool inside = all > 0 ? edgeA >= 0 && edgeB >= 0 && edgeC >= 0 : edgeA <= 0 && edgeB <= 0 && edgeC <= 0;
    m.t = tripleProduct(a, ab, ac) / all;
    m.u = edgeB / all;
    m.v = edgeC / all;
    const Exact n[3] = {ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x};
    m.give = ofHit * s.unit * double((magnitude(n[0]) + magnitude(n[1]) + magnitude(n[2])) / magnitude(all));
    m.hits = inside;
    return m;
}

uint32_t Oracle::best(const Seen& s, Meeting& nearest) const {
    uint32_t found = NO_HIT;
    if (!s.valid) return found;
    for (uint32_t i = 0; i < primitives_.size(); ++i) {
        if (usable_[i] == 0 || !mayMeet(s, primitives_[i])) continue;
        const Meeting m = meet(s, primitives_[i]);
        if (!m.hits || m.t < Exact(s.ray.tMin) || m.t > Exact(s.ray.tMax)) continue;
        if (found != NO_HIT && m.t >= nearest.t) continue;
        nearest = m;
        found = i;
    }
    return found;
}

Hit Oracle::closest(const Ray& ray) const {
    Meeting m;
    const uint32_t found = best(seen(ray), m);
    if (found == NO_HIT) return {std::numeric_limits<float>::infinity(), 0.0f, 0.0f, NO_HIT};
    return {static_cast<float>(m.t), static_cast<float>(m.u), static_cast<float>(m.v), found};
}

std::vector<uint32_t> Oracle::allClosest(const Ray& ray) const {
    const Seen s = seen(ray);
    std::vector<uint32_t> found;
    if (!s.valid) return found;
    Exact nearest = 0;
    for (uint32_t i = 0; i < primitives_.size(); ++i) {
        if (usable_[i] == 0 || !mayMeet(s, primitives_[i])) continue;
        const Meeting m = meet(s, primitives_[i]);
        if (!m.hits || m.t < Exact(s.ray.tMin) || m.t > Exact(s.ray.tMax)) continue;
        const Exact beyond = found.empty() ? Exact(0) : certain(m.t - nearest, magnitude(nearest));
        if (beyond > 0) continue;
        if (found.empty() || beyond < 0) {
            found.clear();
            nearest = m.t;
        }
        found.push_back(i);
    }
    return found;
}

/// The corner as seen along the ray: (x, y) off it, and the distance in z. Double precision is enough to tell 32 u M by.
dvec3 Oracle::sheared(const Seen& s, const vec3& corner) const {
    const dvec3 p = dvec3(corner) - dvec3(s.ray.origin), d(s.ray.direction);
    const int x = (s.z + 1) % 3, y = (s.z + 2) % 3;
    return {p[x] - d[x] / d[s.z] * p[s.z], p[y] - d[y] / d[s.z] * p[s.z], p[s.z] / d[s.z]};
}

bool Oracle::isOpen(const Seen& s) const {
    if (!s.valid) return false;
    Meeting nearest;
    const uint32_t found = best(s, nearest);
    const double rounding = ofHit * s.unit, along = rounding * s.scale;  // the same as a distance along the ray
    const double end = found != NO_HIT ? double(nearest.t) + nearest.give : double{s.ray.tMax} + along;
    const double margin = ofEdge * s.unit;
    std::vector<dvec3> places;
    places.reserve(corners_.size());
    for (const vec3& corner : corners_) places.push_back(sheared(s, corner));
    const auto isNear = [&](const dvec3& a, const dvec3& b) {
        if (std::min(a.z, b.z) > end || std::max(a.z, b.z) < s.ray.tMin - along) return false;
        const dvec2 way(b.x - a.x, b.y - a.y), from(a);
        const double square = glm::dot(way, way);
        const double f = square > 0.0 ? std::clamp(-glm::dot(from, way) / square, 0.0, 1.0) : 0.0;
        return glm::length(from + f * way) <= margin;
    };
    for (const Edge& edge : edges_) {
        const dvec3 &a = places[edge.from], &b = places[edge.to];
        if (!isNear(a, b)) continue;
        const dvec2 way(b.x - a.x, b.y - a.y);
        bool left = false, right = false;
        for (const uint32_t third : edge.across) {
            const dvec2 off(places[third].x - a.x, places[third].y - a.y);
            const double side = (way.x * off.y - way.y * off.x) / std::max(glm::length(way), 1e-300);
            left = left || side > margin;
            right = right || side < -margin;
        }
        if (!left || !right) return true;
    }
    for (uint32_t i = 0; i < primitives_.size(); ++i)
        if (usable_[i] != 0 && isOpenAt(s, primitives_[i], end)) return true;
    return false;
}

/// True if rounding may decide whether the ray meets it, as it ends there or, of a sphere, passes it by so little.
bool Oracle::isOpenAt(const Seen& s, const Primitive& primitive, double end) const {
    const auto isAt = [&](Exact t, double give) {
        const auto ends = [&](float limit) { return std::isfinite(limit) && std::abs(double(t - Exact(limit))) <= give; };
        return ends(s.ray.tMin) || ends(s.ray.tMax);
    };
    if (!primitive.isSphere()) {
        if (!mayMeet(s, primitive)) return false;
        const Meeting m = meet(s, primitive);
        return m.hits && isAt(m.t, m.give);
    }
    const double margin = ofEdge * s.unit, along = ofHit * s.unit * s.scale;
    const Crossing c = cross(s, primitive, 0.0);
    if (std::abs(c.off) <= margin && c.nearest <= end && c.nearest >= s.ray.tMin - along) return true;
    return c.meets && (isAt(c.first, giveOf(s, primitive, c.first)) || isAt(c.second, giveOf(s, primitive, c.second)));
}

bool Oracle::isOpen(const Ray& ray) const {
    return isOpen(seen(ray));
}

Verdict Oracle::verdict(const Seen& s, const Hit& got, bool& sound) const {
    Meeting exact;
    const uint32_t want = best(s, exact);
    sound = true;
    if (got.primitive == NO_HIT) return want == NO_HIT ? Verdict::same : Verdict::missed;
    if (got.primitive >= primitives_.size() || !s.valid || usable_[got.primitive] == 0 || !std::isfinite(got.t)) {
        sound = false;
        return Verdict::phantom;
    }
    const Primitive& t = primitives_[got.primitive];
    const dvec3 o(s.ray.origin), point = double{got.t} * dvec3(s.ray.direction), a = dvec3(t.a) - o;
    const double off = t.isSphere() ? std::abs(glm::length(point - a) - double{t.radius()})
                                    : distanceTo(point, a, dvec3(t.b) - o, dvec3(t.c) - o);
    sound = off <= std::sqrt(3.0) * ofHit * s.unit && got.u >= 0.0f && got.v >= 0.0f && got.u <= 1.0f && got.v <= 1.0f;
    if (want == NO_HIT) return Verdict::phantom;
    const double apart = std::abs(double(Exact(got.t) - exact.t));
    if (got.primitive == want) return apart <= exact.give ? Verdict::same : Verdict::wrong;
    return apart <= exact.give + meet(s, t).give ? Verdict::tie : Verdict::wrong;
}

Judgement Oracle::judge(const Ray& ray, const Hit& hit, bool strict) const {
    const Seen s = seen(ray);
    Judgement judgement;
    judgement.verdict = verdict(s, hit, judgement.sound);
    if (judgement.verdict != Verdict::same && judgement.verdict != Verdict::tie) judgement.open = !strict && isOpen(s);
    return judgement;
}

}  // namespace raig::hard

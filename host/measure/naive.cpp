#include "measure/naive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig::hard::naive {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

float minOf(Slab slab, float x, float y) {
    if (slab == Slab::otherOrder) return x < y ? x : y;
    if (slab == Slab::numbers) return std::fmin(x, y);
    return y < x ? y : x;
}

float maxOf(Slab slab, float x, float y) {
    if (slab == Slab::otherOrder) return x > y ? x : y;
    if (slab == Slab::numbers) return std::fmax(x, y);
    return x < y ? y : x;
}

float inverseOf(Slab slab, float d) {
    const float least = slab == Slab::clamped5 ? 1e-5f : 1e-12f;
    if ((slab == Slab::clamped5 || slab == Slab::clamped12) && std::abs(d) < least) return 1.0f / std::copysign(least, d);
    if (slab == Slab::largest && d == 0.0f) return std::copysign(std::numeric_limits<float>::max(), d);
    return 1.0f / d;
}

float distance(Slab slab, float plane, float origin, float inverse) {
    if (slab == Slab::fused || slab == Slab::largest) return std::fma(plane, inverse, -origin * inverse);
    return (plane - origin) * inverse;
}

vec3 crossOf(bool fused, const vec3& a, const vec3& b) {
    const auto part = [&](float p, float q, float r, float s) { return fused ? std::fma(p, q, -(r * s)) : p * q - r * s; };
    return {part(a.y, b.z, a.z, b.y), part(a.z, b.x, a.x, b.z), part(a.x, b.y, a.y, b.x)};
}

float dotOf(bool fused, const vec3& a, const vec3& b) {
    return fused ? std::fma(a.x, b.x, std::fma(a.y, b.y, a.z * b.z)) : a.x * b.x + a.y * b.y + a.z * b.z;
}

std::optional<float> moellerTrumbore(Tester tester, const Triangle& t, const Ray& ray) {
    const bool fused = tester == Tester::moellerTrumboreFused;
    const vec3 ab = t.b - t.a, ac = t.c - t.a, p = crossOf(fused, ray.direction, ac);
    const float det = dotOf(fused, ab, p);
    if (det == 0.0f || (tester == Tester::moellerTrumboreCull && std::abs(det) < 1e-7f)) return std::nullopt;
    const vec3 from = ray.origin - t.a;
    if (tester == Tester::sameSigns) {
        const auto sign = [](float x) { return float(x > 0.0f) - float(x < 0.0f); };
        const float u = dotOf(false, from, p), v = dotOf(false, ray.direction, crossOf(false, from, ab));
        if (sign(u) != sign(det - u) || sign(v) != sign(det - u - v)) return std::nullopt;
        return dotOf(false, ac, crossOf(false, from, ab)) / det;
    }
    const float inverse = 1.0f / det, u = dotOf(fused, from, p) * inverse;
    if (!(u >= 0.0f && u <= 1.0f)) return std::nullopt;
    const vec3 q = crossOf(fused, from, ab);
    const float v = dotOf(fused, ray.direction, q) * inverse;
    if (!(v >= 0.0f && u + v <= 1.0f)) return std::nullopt;
    return dotOf(fused, ac, q) * inverse;
}

std::optional<float> watertightFused(const Triangle& t, const Ray& ray) {
    const vec3 d = ray.direction, size = glm::abs(d);
    const int z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2), x = (z + 1) % 3, y = (z + 2) % 3;
    const float shearX = d[x] / d[z], shearY = d[y] / d[z];
    const auto sheared = [&](const vec3& corner) {
        const vec3 p = corner - ray.origin;
        return vec2(std::fma(-shearX, p[z], p[x]), std::fma(-shearY, p[z], p[y]));
    };
    const vec2 a = sheared(t.a), b = sheared(t.b), c = sheared(t.c);
    const float u = std::fma(c.x, b.y, -(c.y * b.x)), v = std::fma(a.x, c.y, -(a.y * c.x)),
                w = std::fma(b.x, a.y, -(b.y * a.x));
    if ((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) return std::nullopt;
    const float det = u + v + w;
    if (det == 0.0f) return std::nullopt;
    return (u * (t.a - ray.origin)[z] + v * (t.b - ray.origin)[z] + w * (t.c - ray.origin)[z]) / (det * d[z]);
}

/// In double precision, edges inclusive.
std::optional<double> exactly(const Triangle& t, const Ray& ray) {
    const dvec3 o(ray.origin), d(ray.direction), a = dvec3(t.a) - o, b = dvec3(t.b) - o, c = dvec3(t.c) - o;
    const double u = glm::dot(d, glm::cross(b, c)), v = glm::dot(d, glm::cross(c, a)), w = glm::dot(d, glm::cross(a, b));
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return std::nullopt;
    const double all = u + v + w;
    if (all == 0.0) return std::nullopt;
    return glm::dot(u * a + v * b + w * c, d) / (all * glm::dot(d, d));
}

/// The walk in numbers of type T.
template <class T>
std::optional<std::vector<Visit>> walk(Dda dda, const Box& box, uint32_t n, const Ray& ray) {
    using Vector = glm::vec<3, T>;
    const Vector lo(box.lo), hi(box.hi), step = (hi - lo) / T(n), o(ray.origin), d(ray.direction);
    T enter = T(ray.tMin), leave = T(ray.tMax);
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == T(0)) {
            if (o[axis] < lo[axis] || o[axis] > hi[axis]) return std::vector<Visit>{};
            continue;
        }
        const T first = (lo[axis] - o[axis]) / d[axis], last = (hi[axis] - o[axis]) / d[axis];
        enter = std::max(enter, std::min(first, last));
        leave = std::min(leave, std::max(first, last));
    }
    if (enter > leave) return std::vector<Visit>{};
    const Vector p = o + enter * d;
    glm::ivec3 cell, towards;
    Vector next, delta;
    for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = static_cast<int>((p[axis] - lo[axis]) / step[axis]);
        if (dda != Dda::unclamped) cell[axis] = std::clamp(cell[axis], 0, static_cast<int>(n) - 1);
        towards[axis] = d[axis] >= T(0) ? 1 : -1;
        const T plane = lo[axis] + T(cell[axis] + (towards[axis] > 0 ? 1 : 0)) * step[axis];
        const T from = dda == Dda::reorigin ? p[axis] : o[axis];
        next[axis] = (plane - from) / d[axis] + (dda == Dda::reorigin ? enter : T(0));
        delta[axis] = std::abs(step[axis] / d[axis]);
        if (dda != Dda::noZeros && d[axis] == T(0)) next[axis] = std::numeric_limits<T>::infinity();
    }
    std::vector<Visit> cells;
    const auto end = static_cast<int>(n);
    while (glm::all(glm::greaterThanEqual(cell, glm::ivec3(0))) && glm::all(glm::lessThan(cell, glm::ivec3(end)))) {
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        cells.push_back({static_cast<uint32_t>(cell.x + end * (cell.y + end * cell.z)), double(next[axis])});
        if (cells.size() > 4 * n) return std::nullopt;
        cell[axis] += towards[axis];
        next[axis] += delta[axis];
    }
    return cells;
}

}  // namespace

bool meets(Slab slab, const Box& box, const Ray& ray) {
    float enter = ray.tMin, leave = ray.tMax;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = inverseOf(slab, ray.direction[axis]), o = ray.origin[axis];
        float first = distance(slab, box.lo[axis], o, inverse), second = distance(slab, box.hi[axis], o, inverse);
        if (slab == Slab::signOfValue || slab == Slab::slack) {
            const bool backwards = slab == Slab::slack ? std::signbit(inverse) : !(ray.direction[axis] >= 0.0f);
            if (backwards) std::swap(first, second);
            if (slab == Slab::slack) second = std::nextafter(std::nextafter(second, inf), inf);
            enter = first > enter ? first : enter;
            leave = second < leave ? second : leave;
        } else {
            enter = maxOf(slab, enter, minOf(slab, first, second));
            leave = minOf(slab, leave, maxOf(slab, first, second));
        }
    }
    return slab == Slab::strict ? enter < leave : enter <= leave;
}

std::optional<float> meets(Tester tester, const Triangle& triangle, const Ray& ray) {
    return tester == Tester::watertightFused ? watertightFused(triangle, ray) : moellerTrumbore(tester, triangle, ray);
}

std::optional<float> meetsSphere(const Primitive& sphere, const Ray& ray) {
    const vec3 f = ray.origin - sphere.centre(), d = ray.direction;
    const float a = dotOf(false, d, d), b = 2.0f * dotOf(false, f, d),
                c = dotOf(false, f, f) - sphere.radius() * sphere.radius();
    const float discriminant = b * b - 4.0f * a * c;
    if (discriminant < 0.0f) return std::nullopt;
    const float root = std::sqrt(discriminant), first = (-b - root) / (2.0f * a), second = (-b + root) / (2.0f * a);
    const float t = first >= ray.tMin ? first : second;
    if (t < ray.tMin || t > ray.tMax) return std::nullopt;
    return t;
}

std::optional<std::vector<Visit>> cellsOf(Dda dda, const Box& box, uint32_t n, const Ray& ray) {
    return dda == Dda::sound ? walk<double>(dda, box, n, ray) : walk<float>(dda, box, n, ray);
}

Grid::Grid(const std::vector<Triangle>& triangles, uint32_t n) : triangles_(triangles), n_(n), cells_(n * n * n) {
    for (const Triangle& t : triangles) box_.grow(t.box());
    const vec3 step = box_.extent() / static_cast<float>(n);
    const auto cellAt = [&](const vec3& p) {
        return glm::clamp(glm::ivec3((p - box_.lo) / step), 0, static_cast<int>(n) - 1);
    };
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        const glm::uvec3 lo(cellAt(triangles[i].box().lo)), hi(cellAt(triangles[i].box().hi));
        for (uint32_t z = lo.z; z <= hi.z; ++z)
            for (uint32_t y = lo.y; y <= hi.y; ++y)
                for (uint32_t x = lo.x; x <= hi.x; ++x) cells_[x + n * (y + n * z)].push_back(i);
    }
}

uint32_t Grid::closest(const Ray& ray, bool first) const {
    const auto visits = cellsOf(Dda::single, box_, n_, ray);
    if (!visits) return NO_HIT;
    for (const Visit& visit : *visits) {
        uint32_t best = NO_HIT;
        double nearest = ray.tMax;
        for (const uint32_t i : cells_[visit.cell]) {
            const auto t = exactly(triangles_[i], ray);
            if (!t || *t < ray.tMin || *t >= nearest || (!first && *t > visit.leave)) continue;
            nearest = *t;
            best = i;
        }
        if (best != NO_HIT) return best;
    }
    return NO_HIT;
}

namespace {

struct Candidate {
    uint32_t id;
    double t;
};

uint32_t descend(const std::vector<Candidate>& all, const std::vector<Triangle>& triangles, Box box, const Ray& ray,
                 float tMin, float tMax) {
    const vec3 extent = box.extent();
    const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    if (extent[axis] <= 1.0f) {
        const Candidate* best = nullptr;
        for (const Candidate& c : all)
            if (c.t >= tMin && c.t <= tMax && (best == nullptr || c.t < best->t)) best = &c;
        return best == nullptr ? NO_HIT : best->id;
    }
    const float plane = 0.5f * (box.lo[axis] + box.hi[axis]), t = (plane - ray.origin[axis]) / ray.direction[axis];
    std::vector<Candidate> below, above;
    for (const Candidate& c : all) {
        const Box own = triangles[c.id].box();
        if (own.lo[axis] < plane || own.hi[axis] <= plane) below.push_back(c);
        if (own.hi[axis] > plane) above.push_back(c);
    }
    Box low = box, high = box;
    low.hi[axis] = high.lo[axis] = plane;
    const bool fromBelow = ray.origin[axis] < plane;
    const auto near = [&](float end) {
        return descend(fromBelow ? below : above, triangles, fromBelow ? low : high, ray, tMin, end);
    };
    const auto far = [&](float start) {
        return descend(fromBelow ? above : below, triangles, fromBelow ? high : low, ray, start, tMax);
    };
    if (t >= tMax || t <= 0.0f) return near(tMax);
    if (!(t > tMin)) return far(tMin);
    const uint32_t found = near(t);
    return found != NO_HIT ? found : far(t);
}

}  // namespace

uint32_t closestByKdTree(const std::vector<Triangle>& triangles, const Box& box, const Ray& ray) {
    std::vector<Candidate> met;
    for (uint32_t i = 0; i < triangles.size(); ++i)
        if (const auto t = exactly(triangles[i], ray)) met.push_back({i, *t});
    return descend(met, triangles, box, ray, ray.tMin, ray.tMax);
}

}  // namespace raig::hard::naive

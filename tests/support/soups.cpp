#include "support/soups.hpp"

#include "base/random.hpp"
#include "support/sphere_soups.hpp"

#include <fmt/format.h>

#include <limits>
#include <numbers>
#include <stdexcept>

namespace raig::test {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

Triangle randomTriangle(Random& random, double size) {
    const dvec3 at = dvec3(random.inCube(-1, 1));
    const auto corner = [&] { return vec3(at + size * dvec3(random.inCube(-1, 1))); };
    return {corner(), corner(), corner()};
}

std::vector<Triangle> randomTriangles(uint64_t seed, size_t count, double size) {
    Random random(seed);
    std::vector<Triangle> triangles;
    for (size_t i = 0; i < count; ++i) triangles.push_back(randomTriangle(random, size));
    return triangles;
}

std::vector<Triangle> moved(std::vector<Triangle> triangles, double scale, dvec3 offset) {
    for (Triangle& t : triangles)
        for (vec3* corner : {&t.a, &t.b, &t.c}) *corner = vec3(dvec3(*corner) * scale + offset);
    return triangles;
}

std::vector<Triangle> joined(std::vector<Triangle> a, const std::vector<Triangle>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<Triangle> slivers(size_t count) {
    Random random(3);
    std::vector<Triangle> triangles;
    for (size_t i = 0; i < count; ++i) {
        const vec3 a = random.inCube(-1, 1), b = random.inCube(-1, 1);
        triangles.push_back({a, b, vec3(dvec3(b) + 1e-6 * random.direction())});
    }
    return triangles;
}

/// A grid of squares in the plane z = 0.25, two triangles each, and the same in x and y: all flat along an axis.
std::vector<Triangle> walls(uint32_t side) {
    std::vector<Triangle> triangles;
    for (int axis = 0; axis < 3; ++axis)
        for (uint32_t i = 0; i < side; ++i)
            for (uint32_t j = 0; j < side; ++j) {
                const auto at = [&](uint32_t k, uint32_t l) {
                    vec3 p(0.25f);
                    p[(axis + 1) % 3] = static_cast<float>(k) / 8.0f;
                    p[(axis + 2) % 3] = static_cast<float>(l) / 8.0f;
                    return p;
                };
                triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    return triangles;
}

std::vector<Triangle> withUnusable() {
    std::vector<Triangle> triangles = randomTriangles(5, 300, 0.2);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const vec3 p(0.5f), q(0.25f, 0.5f, 0.75f);
    const std::vector<Triangle> bad = {
        {vec3(nan), p, q}, {p, vec3(inf, 0, 0), q},     {p, q, vec3(0, 1e30f, 0)},         {p, p, q},
        {p, p, p},         {vec3(0), vec3(1), vec3(2)}, {vec3(-inf), vec3(inf), vec3(nan)}};
    for (size_t i = 0; i < bad.size(); ++i) triangles.insert(triangles.begin() + static_cast<long>(i * 40), bad[i]);
    return triangles;
}

std::vector<Triangle> fan(size_t count) {
    std::vector<Triangle> triangles;
    Random random(11);
    for (size_t i = 0; i < count; ++i)
        triangles.push_back({vec3(0.1f, 0.2f, 0.3f), random.inCube(-1, 1), random.inCube(-1, 1)});
    return triangles;
}

/// A wall of squares, two triangles each, in a plane that no axis lies in, and one behind it: flat, and in no box that is.
std::vector<Triangle> tiltedWalls(uint32_t side) {
    const dvec3 along(0.8, 0.1, -0.3), up(-0.2, 0.7, 0.4), behind(0.01, -0.02, 0.03);
    std::vector<Triangle> triangles;
    for (int wall = 0; wall < 2; ++wall)
        for (uint32_t i = 0; i < side; ++i)
            for (uint32_t j = 0; j < side; ++j) {
                const auto at = [&](uint32_t k, uint32_t l) {
                    return vec3((k / 4.0 - 1.0) * along + (l / 4.0 - 1.0) * up + double(wall) * behind);
                };
                triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    return triangles;
}

/// Large triangles around one edge, at every angle: whoever looks along it sees all of them edge-on.
std::vector<Triangle> pages(size_t count) {
    const dvec3 bottom(-0.3, -0.9, 0.2), spine(0.5, 1.7, -0.4);
    const dvec3 u = glm::normalize(glm::cross(spine, dvec3(1, 0, 0))), v = glm::normalize(glm::cross(spine, u));
    std::vector<Triangle> triangles;
    for (size_t i = 0; i < count; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
        const dvec3 out = 1.3 * (std::cos(angle) * u + std::sin(angle) * v);
        triangles.push_back({vec3(bottom), vec3(bottom + spine), vec3(bottom + 0.4 * spine + out)});
    }
    return triangles;
}

}  // namespace

std::vector<Soup> soups() {
    const std::vector<Triangle> ordinary = randomTriangles(1, 2000, 0.1);
    const Triangle one{vec3(-0.5f, -0.5f, 0.0f), vec3(0.5f, -0.25f, 0.125f), vec3(0.0f, 0.5f, 0.25f)};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<Triangle> floor = {{vec3(-1000, -1, -1000), vec3(1000, -1, -1000), vec3(1000, -1, 1000)},
                                         {vec3(-1000, -1, -1000), vec3(1000, -1, 1000), vec3(-1000, -1, 1000)}};
    std::vector<Soup> soups = {
        {"none", {}},
        {"one", {one}},
        {"all unusable", {{vec3(nan), vec3(nan), vec3(nan)}, {vec3(1), vec3(1), vec3(1)}}},
        {"some unusable", withUnusable()},
        {"ordinary", ordinary},
        {"overlapping", randomTriangles(2, 500, 1.0)},
        {"slivers", slivers(1000)},
        {"walls", walls(12)},
        {"duplicates", std::vector<Triangle>(300, one)},
        {"two of each", joined(ordinary, ordinary)},
        {"fan", fan(500)},
        {"tilted walls", tiltedWalls(8)},
        {"pages", pages(120)},
        {"sphere", sphere(16, 2.0, dvec3(0), 0.2)},
        {"far", moved(ordinary, 1.0, dvec3(1e4, -2e4, 3e4))},
        {"tiny", moved(ordinary, 2e-13, dvec3(0))},
        {"huge", moved(ordinary, 2e9, dvec3(0))},
        {"stadium", joined(floor, sphere(16, 1.0, dvec3(0), 0.1))},
    };
    for (Soup& soup : sphereSoups()) soups.push_back(std::move(soup));
    return soups;
}

namespace {

struct Aim {
    Box box;
    const std::vector<Primitive>& triangles;
    std::vector<uint32_t> usable;
    double size;
};

vec3 pointOn(const Aim& aim, Random& random) {
    if (aim.usable.empty()) return random.inCube(-1, 1);
    const Triangle& t = aim.triangles[aim.usable[random.below(static_cast<uint32_t>(aim.usable.size()))]];
    if (t.isSphere()) return pointOnSphere(t, random);
    switch (random.below(3)) {
        case 0:
            return t.a;  // a vertex
        case 1: {        // a point of an edge, or its middle
            const double f = random.below(2) == 0 ? 0.5 : random.unit();
            return vec3(glm::mix(dvec3(t.a), dvec3(t.b), f));
        }
        default: {
            const double r = std::sqrt(random.unit()), s = random.unit();
            return vec3((1 - r) * dvec3(t.a) + r * (1 - s) * dvec3(t.b) + r * s * dvec3(t.c));
        }
    }
}

vec3 originAround(const Aim& aim, Random& random) {
    const double reach = random.below(4) == 0 ? 0.3 : 2.0;
    return vec3(dvec3(aim.box.centre()) + reach * aim.size * dvec3(random.inCube(-1, 1)));
}

Ray axisRay(const Aim& aim, Random& random) {
    const vec3 at = pointOn(aim, random);
    Ray ray{at, 0.0f, vec3(0.0f), inf};
    const auto axis = static_cast<int>(random.below(3));
    for (int other = 0; other < 3; ++other) ray.direction[other] = random.below(2) == 0 ? 0.0f : -0.0f;
    ray.direction[axis] = random.below(2) == 0 ? 1.0f : -1.0f;
    ray.origin[axis] -= static_cast<float>(3.0 * aim.size) * ray.direction[axis];
    if (random.below(3) == 0) {  // in the plane of a face of the whole, or of a triangle's box
        const int side = (axis + 1 + static_cast<int>(random.below(2))) % 3;
        ray.origin[side] = random.below(2) == 0 ? aim.box.lo[side] : aim.box.hi[side];
    }
    if (random.below(4) == 0) ray.direction[(axis + 1) % 3] = static_cast<float>(random.within(-1, 1));  // one zero left
    return ray;
}

/// In a triangle's plane, as nearly as floats allow, or at a small angle to it: from a point of the plane, on the triangle
/// or off it, along a combination of its edges. At a sphere: as rayAtSphere.
Ray grazingRay(const Aim& aim, Random& random) {
    if (aim.usable.empty()) return {random.inCube(-1, 1), 0.0f, vec3(random.direction()), inf};
    const Triangle& t = aim.triangles[aim.usable[random.below(static_cast<uint32_t>(aim.usable.size()))]];
    if (t.isSphere()) return rayAtSphere(t, random);
    const dvec3 edges[2] = {dvec3(t.b) - dvec3(t.a), dvec3(t.c) - dvec3(t.a)};
    const double reach = random.below(3) == 0 ? 10.0 : 1.0;
    const double p = reach * random.within(-1, 1), q = reach * random.within(-1, 1);
    dvec3 direction = random.within(-1, 1) * edges[0] + random.within(-1, 1) * edges[1];
    if (random.below(4) == 0) direction = random.below(2) == 0 ? edges[0] : edges[1] - edges[0];  // along an edge
    if (random.below(4) == 0)
        direction += std::pow(10.0, random.within(-9, -2)) * glm::length(direction) * random.direction();
    vec3 origin = random.below(4) == 0 ? t.a : vec3(dvec3(t.a) + p * edges[0] + q * edges[1]);
    if (random.below(4) == 0) origin = vec3(dvec3(origin) - random.within(0, 50) * direction);
    const double length = glm::length(direction);
    return {origin, 0.0f, vec3(length > 0.0 ? direction / length : dvec3(1, 0, 0)), inf};
}

}  // namespace

std::vector<Triangle> soupNamed(const std::string& name) {
    for (const Soup& soup : soups())
        if (soup.name == name) return soup.triangles;
    throw std::out_of_range("no soup " + name);
}

std::vector<Ray> rays(const std::vector<Triangle>& triangles, uint64_t seed, size_t count) {
    Aim aim{{}, triangles, {}, 1.0};
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        if (!triangles[i].usable()) continue;
        aim.usable.push_back(i);
        aim.box.grow(triangles[i].box());
    }
    if (aim.usable.empty()) aim.box = {vec3(-1.0f), vec3(1.0f)};
    aim.size = glm::length(dvec3(aim.box.extent())) / 2.0;

    Random random(seed);
    std::vector<Ray> result;
    for (size_t i = 0; i < count; ++i) {
        Ray ray{originAround(aim, random), 0.0f, vec3(random.direction()), inf};
        const vec3 target = pointOn(aim, random);
        const dvec3 towards = dvec3(target) - dvec3(ray.origin);
        switch (i % 10) {
            case 0:
                break;
            case 1:
                ray = axisRay(aim, random);
                break;
            case 2:
                ray.direction = vec3(towards / glm::length(towards));
                break;
            case 3:
                ray.direction = vec3(towards);
                break;  // not normalised, and t = 1 at the target
            case 4:
                ray.origin = pointOn(aim, random);
                break;
            case 5: {  // at a corner of the bounds
                vec3 corner;
                for (int axis = 0; axis < 3; ++axis)
                    corner[axis] = random.below(2) == 0 ? aim.box.lo[axis] : aim.box.hi[axis];
                ray.direction = corner - ray.origin;
                break;
            }
            case 6: {  // nearly along an axis
                const auto axis = static_cast<int>(random.below(3));
                ray.direction = vec3(random.direction() * std::pow(10.0, random.within(-12, -3)));
                ray.direction[axis] = 1.0f;
                ray.origin = vec3(dvec3(target) - dvec3(ray.direction) * 2.0 * aim.size);
                break;
            }
            case 7:
            case 8:
                ray = grazingRay(aim, random);
                break;
            default:  // a stretch of a ray, of any length
                ray.direction = vec3(towards * std::pow(10.0, random.within(-13, 6)));
                ray.tMin =
                    static_cast<float>(random.within(0.0, 1.0) * glm::length(towards) / glm::length(dvec3(ray.direction)));
                ray.tMax = ray.tMin * static_cast<float>(random.within(1.0, 3.0));
                break;
        }
        result.push_back(ray);
    }
    return result;
}

}  // namespace raig::test

// Cases 13 to 31: what single triangles and meshes of them ask of the intersection.
#include "measure/hard_cases.hpp"
#include "measure/hard_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace raig::hard {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// From inside a sphere at its vertices, or at points of its edges: no ray is open.
Scene insideSphere(const Draw& draw, const char* name, uint32_t rings, double radius, const dvec3& centre, bool vertices,
                   uint64_t seed) {
    Scene scene{name, sphere(rings, radius, centre), {}, false, 0.0};
    Random random = draw.random(seed);
    while (scene.rays.size() < draw.rays(800)) {
        const Triangle& t = scene.triangles[random.below(static_cast<uint32_t>(scene.triangles.size()))];
        const dvec3 target = glm::mix(dvec3(t.a), dvec3(t.b), vertices ? 0.0 : random.unit());
        const vec3 origin = vec3(centre + 0.3 * radius * dvec3(random.inCube(-1, 1)));
        scene.rays.push_back({origin, 0.0f, vec3(target - dvec3(origin)), inf});
    }
    return scene;
}

/// Vertices and edges, in this order.
std::vector<Scene> bothInside(const Draw& draw, uint32_t rings, double radius, const dvec3& centre, uint64_t seed) {
    return {insideSphere(draw, "vertices", rings, radius, centre, true, seed),
            insideSphere(draw, "edges", rings, radius, centre, false, seed + 1)};
}

/// Case 20: exactly on edges and corners of squares, along slopes that are powers of two.
std::vector<Scene> exactlyOnEdges(const Draw& draw) {
    Scene scene{"whole numbers", {}, {}, true, 0.0};
    for (int axis = 0; axis < 3; ++axis)
        for (const Triangle& t : squares(axis, 4.0f, 8)) scene.triangles.push_back(t);
    Random random = draw.random(31);
    while (scene.rays.size() < draw.rays(1500)) {
        const auto axis = static_cast<int>(random.below(3));
        vec3 target(static_cast<float>(random.below(9)), static_cast<float>(random.below(9)),
                    static_cast<float>(random.below(9)));
        target[axis] = 4.0f;
        if (random.below(2) == 0) target[(axis + 1) % 3] += 0.5f;
        if (random.below(4) == 0) target[(axis + 2) % 3] = target[(axis + 1) % 3];  // on a diagonal
        vec3 direction(0.0f);
        for (int k = 0; k < 3; ++k)
            if (k != axis)
                direction[k] = std::ldexp(random.below(2) == 0 ? 1.0f : -1.0f, -static_cast<int>(1 + random.below(4)));
        if (random.below(2) == 0) direction[(axis + 1) % 3] = anyZero(random);
        direction[axis] = random.below(2) == 0 ? 1.0f : -1.0f;
        scene.rays.push_back({target - 8.0f * direction, 0.0f, direction, inf});
    }
    return {scene};
}

/// Case 22: a mesh twice, with the copies after, before and among the originals.
std::vector<Scene> duplicated(const Draw& draw) {
    std::vector<Scene> scenes;
    for (const char* order : {"after", "reversed", "mixed"}) {
        Scene scene = insideSphere(draw, order, 12, 1.0, dvec3(0.1, 0.2, -0.3), false, 33);
        std::vector<Triangle> copy = scene.triangles;
        if (order[0] == 'r') std::reverse(copy.begin(), copy.end());
        scene.triangles.insert(scene.triangles.end(), copy.begin(), copy.end());
        Random random = draw.random(34);
        if (order[0] == 'm')
            for (size_t i = scene.triangles.size() - 1; i > 0; --i)
                std::swap(scene.triangles[i], scene.triangles[random.below(static_cast<uint32_t>(i + 1))]);
        scenes.push_back(scene);
    }
    return scenes;
}

/// Case 23: copies of one triangle, and one before them.
std::vector<Scene> copies(const Draw& draw) {
    const Triangle one{vec3(-1, -1, 1), vec3(1, -1, 1.125f), vec3(0, 1, 0.875f)};
    Scene scene{"10,000 of one", std::vector<Triangle>(10'000, one), {}, false, 0.02};
    scene.triangles[7000] = {vec3(-1, -1, 0.5f), vec3(1, -1, 0.5f), vec3(0, 1, 0.5f)};
    Random random = draw.random(35);
    while (scene.rays.size() < draw.rays(40))
        scene.rays.push_back(
            {random.inCube(-1, 1) * vec3(1, 1, 0), 0.0f, vec3(dvec3(0, 0, 1) + 0.1 * random.direction()), inf});
    return {scene};
}

/// Case 24: slivers, 1e-6 wide, half a degree off their planes. None is closed: nothing tells but soundness.
std::vector<Scene> slivers(const Draw& draw) {
    Scene scene{"slivers", {}, {}, false, 1.0};
    Random random = draw.random(36);
    for (int i = 0; i < 300; ++i) {
        const dvec3 at = 10.0 * dvec3(random.inCube(-1, 1)), along = random.direction();
        const dvec3 across = glm::normalize(glm::cross(along, random.direction())), normal = glm::cross(along, across);
        // Edges of 11.2, 9.7 and some 1.5 at a width of 1e-6.
        scene.triangles.push_back({vec3(at), vec3(at + 11.2 * along), vec3(at + 9.7 * along + 1e-6 * across)});
        for (size_t k = 0; k < draw.rays(4); ++k) {
            const double angle = random.within(0.0, 2.0), tilt = std::numbers::pi / 360.0;
            const dvec3 flat = std::cos(angle) * along + std::sin(angle) * across;
            const dvec3 direction = std::cos(tilt) * flat + std::sin(tilt) * normal;
            const dvec3 target = at + random.within(0.0, 11.2) * along + random.within(-1e-6, 2e-6) * across;
            scene.rays.push_back({vec3(target - random.within(1.0, 100.0) * direction), 0.0f, vec3(direction), inf});
        }
    }
    return {scene};
}

/// Case 25: among others, triangles without an area; with rays at these.
std::vector<Scene> withoutArea(const Draw& draw) {
    Scene scene = insideSphere(draw, "points and lines", 10, 2.0, dvec3(0), false, 37);
    Random random = draw.random(38);
    for (int i = 0; i < 60; ++i) {
        const vec3 p = vec3(glm::floor(dvec3(random.inCube(-8, 8)))) / 8.0f, q = p + vec3(0.25f, 0.5f, -0.125f);
        const Triangle none[4] = {{p, q, 0.5f * (p + q)}, {p, p, q}, {p, q, q}, {p, p, p}};
        scene.triangles.insert(scene.triangles.begin() + 7 * i, none[i % 4]);
        for (size_t k = 0; k < draw.rays(4); ++k) {
            const vec3 origin = vec3(0.6 * dvec3(random.inCube(-1, 1)));
            scene.rays.push_back({origin, 0.0f, p + static_cast<float>(k % 3) * 0.5f * (q - p) - origin, inf});
        }
    }
    return {scene};
}

/// Case 27: triangles that all hold one direction in their planes, and rays along it, exactly: between eighths, at slopes
/// that are powers of two. No ray hits anything.
std::vector<Scene> inPlanes(const Draw& draw) {
    std::vector<Scene> scenes;
    for (int number = 0; number < 6; ++number) {
        vec3 along(0.0f);
        along[number % 3] = 1.0f;
        along[(number + 1) % 3] = number < 3 ? 0.0f : std::ldexp(1.0f, -number);
        along[(number + 2) % 3] = number < 5 ? 0.0f : -0.5f;
        Scene scene{fmt::format("along {}", number), {}, {}, true, 0.0};
        Random random = draw.random(39 + static_cast<uint64_t>(number));
        const auto eighths = [&] { return vec3(glm::floor(dvec3(random.inCube(-8, 8)))) / 8.0f; };
        for (int i = 0; i < 100; ++i) {
            const vec3 a = eighths(), across = eighths();
            scene.triangles.push_back({a, a + 0.5f * along, a + across});
            for (size_t k = 0; k < draw.rays(3); ++k) {
                const vec3 at = a + static_cast<float>(random.below(5)) * 0.25f * across;
                const float way = random.below(2) == 0 ? 1.0f : -1.0f, back = static_cast<float>(random.below(5));
                scene.rays.push_back({at - way * back * along, 0.0f, way * along, inf});
            }
        }
        scenes.push_back(scene);
    }
    return scenes;
}

/// Case 28: among others, triangles with corners that are not numbers, or too large: the others are hit as ever.
std::vector<Scene> beyondNumbers(const Draw& draw) {
    Scene scene = insideSphere(draw, "NaN, inf, 1e30, beyond 1.844e18", 10, 2.0, dvec3(0), false, 45);
    Random random = draw.random(46);
    const float bad[] = {nan, inf, -inf, 1e30f, -1e30f, 1.8450e18f, 3.4e38f};
    for (int i = 0; i < 70; ++i) {
        Triangle t{random.inCube(-1, 1), random.inCube(-1, 1), random.inCube(-1, 1)};
        vec3* const corners[3] = {&t.a, &t.b, &t.c};
        (*corners[random.below(3)])[static_cast<int>(random.below(3))] = bad[i % 7];
        scene.triangles.insert(scene.triangles.begin() + 5 * i, t);
    }
    return {scene};
}

/// Case 30: nothing, one triangle, none that can be hit.
std::vector<Scene> nearlyNothing(const Draw& draw) {
    const Triangle one{vec3(-0.5f, -0.5f, 0.0f), vec3(0.5f, -0.25f, 0.125f), vec3(0.0f, 0.5f, 0.25f)};
    std::vector<Scene> scenes = {{"none", {}, {}, false, 0.0},
                                 {"one", {one}, {}, false, 1.0},
                                 {"invalid", {{vec3(nan), vec3(0), vec3(1)}, {vec3(1), vec3(1), vec3(1)}}, {}, false, 0.0}};
    for (Scene& scene : scenes) {
        Random random = draw.random(47);
        while (scene.rays.size() < draw.rays(500)) {
            const vec3 origin = random.inCube(-1, 1), target = random.below(4) == 0 ? one.b : random.inCube(-0.5, 0.5);
            scene.rays.push_back({origin, 0.0f, random.below(2) == 0 ? target - origin : vec3(random.direction()), inf});
            if (random.below(4) == 0) scene.rays.back().tMax = static_cast<float>(random.unit());
        }
    }
    return scenes;
}

/// Case 31: rays that are none, among some that are.
std::vector<Scene> noRays(const Draw& draw) {
    Scene scene = insideSphere(draw, "NaN, inf, empty intervals, no direction", 12, 2.0, dvec3(0), false, 48);
    Random random = draw.random(49);
    const float bad[] = {nan, inf, -inf};
    for (size_t i = 0; i < scene.rays.size(); ++i) {
        Ray& ray = scene.rays[i];
        const auto axis = static_cast<int>(random.below(3));
        switch (i % 8) {
            case 0:
                ray.origin[axis] = bad[random.below(3)];
                break;
            case 1:
                ray.direction[axis] = bad[random.below(3)];
                break;
            case 2:
                ray.tMin = bad[random.below(2)], ray.tMax = 1e30f;
                break;
            case 3:
                ray.tMax = random.below(2) == 0 ? nan : -1.0f;
                break;
            case 4:
                ray.tMin = 2.0f, ray.tMax = 1.0f;
                break;
            case 5:
                ray.direction = vec3(anyZero(random), anyZero(random), anyZero(random));
                break;
            case 6:
                ray.direction = vec3(1e-41f, anyZero(random), -1e-45f);
                break;
            default:
                break;
        }
    }
    return {scene};
}

}  // namespace

std::vector<Case> triangleCases() {
    return {
        {13, "at shared vertices", [](const Draw& draw) { return std::vector{bothInside(draw, 24, 2.0, dvec3(0), 23)[0]}; }},
        {14, "at shared edges", [](const Draw& draw) { return std::vector{bothInside(draw, 24, 2.0, dvec3(0), 23)[1]}; }},
        {15, "where a fused multiply-add would leak",
         [](const Draw& draw) { return bothInside(draw, 20, 2.0, dvec3(0), 25); }},
        {16, "where Embree tests",
         [](const Draw& draw) { return bothInside(draw, 24, 2.0, dvec3(148376, 1234, -223423), 27); }},
        {17, "1e6 off the origin", [](const Draw& draw) { return bothInside(draw, 10, 2.0, dvec3(1e6), 29); }},
        {18, "of radius 2e-6", [](const Draw& draw) { return bothInside(draw, 24, 2e-6, dvec3(0), 30); }},
        {19, "of radius 2e-13", [](const Draw& draw) { return bothInside(draw, 24, 2e-13, dvec3(0), 31); }},
        {20, "exactly on edges", exactlyOnEdges},
        {22, "duplicates", duplicated},
        {23, "10,000 copies of one triangle", copies},
        {24, "slivers seen at half a degree", slivers},
        {25, "triangles without an area", withoutArea},
        {27, "rays in the planes of triangles", inPlanes},
        {28, "corners beyond numbers", beyondNumbers},
        {30, "nearly nothing", nearlyNothing},
        {31, "rays that are none", noRays},
    };
}

}  // namespace raig::hard

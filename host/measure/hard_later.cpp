// Cases 50, 51 and 63: rays that leave surfaces, spheres, and meshes that stand in several places.
#include "measure/hard_cases.hpp"
#include "measure/hard_meshes.hpp"
#include "measure/spawn_policies.hpp"
#include "rays/primitives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig::hard {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

// ---- Case 50 -----------------------------------------------------------------------------------------------------------

bool overlap(const Box& a, const Box& b) {
    for (int axis = 0; axis < 3; ++axis)
        if (a.lo[axis] > b.hi[axis] || b.lo[axis] > a.hi[axis]) return false;
    return true;
}

/// Pairs of triangles that keep out of each other's way: what leaves the one of a pair must hit the other.
Scene leaving(const Draw& draw, const SpawnScale& scale, uint64_t seed) {
    Scene scene{fmt::format("size {:g} at {:g}, gap {}", scale.size, scale.place,
                            scale.gap > 0.0 ? fmt::format("{:g} of it", scale.gap) : "8 ULP"),
                {},
                {},
                false,
                1.0};
    const auto number = static_cast<uint32_t>(draw.random(seed).bits());
    uint32_t kept = 0;
    for (const SpawnPair& pair : spawnPairs(scale, 60, number)) {
        const bool isFree = std::none_of(scene.triangles.begin(), scene.triangles.end(), [&](const Triangle& t) {
            return overlap(t.box(), pair.left.box()) || overlap(t.box(), pair.next.box());
        });
        if (!isFree) continue;
        // The one that is left comes before the other, or after it: at equal distances the first counts.
        const auto first = static_cast<uint32_t>(scene.triangles.size());
        const bool leftFirst = kept++ % 2 == 0;
        scene.triangles.push_back(leftFirst ? pair.left : pair.next);
        scene.triangles.push_back(leftFirst ? pair.next : pair.left);
        for (const Ray& ray : spawnRays(SpawnPolicy::bounds, pair, scale, draw.rays(15), number + kept)) {
            scene.rays.push_back(ray);
            scene.meets.push_back(leftFirst ? first + 1 : first);
        }
    }
    return scene;
}

/// All scales, next to what is 8 ULP away; and some where the gap can be seen.
std::vector<Scene> spawned(const Draw& draw) {
    std::vector<SpawnScale> scales = spawnScales(0.0);
    scales.push_back({1e-3, 0.0});
    scales.push_back({1.0, 1e4});
    std::vector<Scene> scenes;
    for (const SpawnScale& scale : scales) scenes.push_back(leaving(draw, scale, 70 + scenes.size()));
    return scenes;
}

// ---- Case 51 -----------------------------------------------------------------------------------------------------------

/// A ray from `origin` that passes a point `off` away from `centre`, across its way.
Ray passing(Random& random, const vec3& origin, const dvec3& centre, double off) {
    const dvec3 way = glm::normalize(centre - dvec3(origin));
    const dvec3 across = glm::normalize(glm::cross(way, random.direction()));
    return {origin, 0.0f, vec3(glm::normalize(centre + off * across - dvec3(origin))), inf};
}

/// Spheres about one centre, 4e-5 apart, in no order; with rays from within all, from outside, and along surfaces.
Scene shells(const Draw& draw) {
    Scene scene{"shells", {}, {}, false, 0.05};
    const vec3 centre(0.25f, -0.5f, 0.125f);
    for (int i = 0; i < 25; ++i) scene.triangles.push_back(Primitive::sphere(centre, 1.0f + 4e-5f * float(i * 7 % 25)));
    Random random = draw.random(80);
    while (scene.rays.size() < draw.rays(600)) {
        const dvec3 out = random.direction();
        const bool within = random.below(3) == 0;
        const vec3 origin(dvec3(centre) + (within ? random.within(0.0, 0.5) : random.within(1.1, 4.0)) * out);
        if (within)
            scene.rays.push_back({origin, 0.0f, vec3(random.direction()), inf});
        else
            scene.rays.push_back(
                passing(random, origin, dvec3(centre),
                        random.below(2) == 0 ? random.within(0.0, 1.2) : 1.0 + 4e-5 * random.within(-1.0, 26.0)));
    }
    return scene;
}

/// A sphere, and some about it, from far away.
Scene farSpheres(const Draw& draw, double distance, uint64_t seed) {
    Scene scene{fmt::format("{:g} away", distance), {Primitive::sphere(vec3(0.0f), 1.0f)}, {}, false, 1.0};
    Random random = draw.random(seed);
    for (int i = 0; i < 12; ++i)
        scene.triangles.push_back(Primitive::sphere(vec3(8.0 * random.direction()), float(random.within(0.1, 1.0))));
    while (scene.rays.size() < draw.rays(300))
        scene.rays.push_back(
            passing(random, vec3(distance * random.direction()), dvec3(0.0), 1.5 * std::sqrt(random.unit())));
    return scene;
}

/// Spheres and triangles that touch, cut and hold each other; with rays from inside, too.
Scene spheresAndTriangles(const Draw& draw) {
    Scene scene{"with triangles", {}, {}, false, 0.3};
    for (const Triangle& t : squares(2, 0.0f, 4)) scene.triangles.push_back(t);
    Random random = draw.random(81);
    for (int i = 0; i < 40; ++i) {
        const float radius = std::ldexp(1.0f, -static_cast<int>(random.below(4)));
        vec3 centre = vec3(2.0f) + vec3(glm::floor(dvec3(random.inCube(-16, 16)))) / 8.0f;
        if (i % 2 == 0) centre.z = radius;  // touches the wall
        scene.triangles.push_back(Primitive::sphere(centre, radius));
    }
    while (scene.rays.size() < draw.rays(600)) {
        const Primitive& at = scene.triangles[random.below(static_cast<uint32_t>(scene.triangles.size()))];
        const vec3 origin = random.below(3) == 0 ? at.a : vec3(2.0f) + 5.0f * random.inCube(-1, 1);
        const vec3 aim = random.below(2) == 0 ? at.a : vec3(2.0f) + 2.0f * random.inCube(-1, 1);
        const bool leaves = origin == aim;
        scene.rays.push_back({origin, 0.0f, leaves ? vec3(random.direction()) : aim - origin, inf});
    }
    return scene;
}

std::vector<Scene> roundOnes(const Draw& draw) {
    std::vector<Scene> scenes = {shells(draw), spheresAndTriangles(draw)};
    for (const double distance : {1e2, 1e3, 1e4, 1e6}) scenes.push_back(farSpheres(draw, distance, 82 + scenes.size()));
    return scenes;
}

// ---- Case 63 -----------------------------------------------------------------------------------------------------------

/// Turns, scales, mirrors and skews, each by its number, and moves to around `centre`.
dmat4 anyPlace(Random& random, int number, const dvec3& centre, double reach, double size) {
    const dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction()));
    const dmat4 turn(dvec4(x, 0), dvec4(y, 0), dvec4(glm::cross(x, y), 0), dvec4(0, 0, 0, 1));
    dmat4 move(1.0), scale(size), skew(1.0);
    scale[3][3] = 1.0;
    if (number % 3 == 1) scale[0] *= random.within(0.1, 4.0);
    if (number % 5 == 3) scale[1] *= -1.0;
    if (number % 4 == 2) skew[1].x = random.within(-1.5, 1.5);
    move[3] = dvec4(centre + reach * dvec3(random.inCube(-1, 1)), 1.0);
    return move * turn * skew * scale;
}

/// Closed meshes in many places; rays at their vertices and edges, along axes, and anywhere.
Scene placed(const Draw& draw, const char* name, const dvec3& centre, double size, double least, uint64_t seed) {
    Random random = draw.random(seed);
    auto whole = std::make_shared<raig::Scene>();
    whole->materials.emplace_back();
    Random shape(90);
    whole->meshes = {meshOf(sphere(6, 1.0, dvec3(0), 0.1)), meshOf(randomCutBox(shape, dvec3(0.1), 1.5, 1).triangles())};
    for (int i = 0; i < 20; ++i)
        whole->instances.push_back(
            {static_cast<uint32_t>(i % 2), anyPlace(random, i, centre, 4.0 * size, size * std::pow(least, random.unit()))});
    Scene scene{name, primitivesOf(flatten(*whole)), {}, false, 0.35};
    scene.placed = whole;
    while (scene.rays.size() < draw.rays(500)) {
        const Triangle& t = scene.triangles[random.below(static_cast<uint32_t>(scene.triangles.size()))];
        const vec3 origin(centre + 6.0 * size * dvec3(random.inCube(-1, 1)));
        const dvec3 target = glm::mix(dvec3(t.a), dvec3(t.b), random.below(2) == 0 ? 0.0 : random.unit());
        vec3 direction(target - dvec3(origin));
        if (random.below(5) == 0) {
            direction = vec3(anyZero(random), anyZero(random), anyZero(random));
            direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 1.0f : -1.0f;
        }
        scene.rays.push_back({random.below(4) == 0 ? t.a - 2.0f * direction : origin, 0.0f, direction, inf});
    }
    return scene;
}

std::vector<Scene> instances(const Draw& draw) {
    return {placed(draw, "of all sizes", dvec3(0), 1.0, 1e-4, 91),
            placed(draw, "1e5 off the origin", dvec3(1e5, -1e5, 1e5), 1.0, 0.3, 92)};
}

}  // namespace

std::vector<Case> laterCases() {
    return {
        {50, "rays that leave surfaces", spawned},
        {51, "spheres in spheres, and far away", roundOnes},
        {63, "meshes in several places", instances},
    };
}

}  // namespace raig::hard

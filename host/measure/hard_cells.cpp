// Cases 32 to 49: what structures that cut space may lose in the planes between their cells, and how large they may grow.
#include "measure/hard_cases.hpp"
#include "measure/hard_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig::hard {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

Box boundsOf(const std::vector<Triangle>& triangles) {
    Box box;
    for (const Triangle& t : triangles) box.grow(t.box());
    return box;
}

/// A sphere in a larger cut box.
std::vector<Triangle> sphereInBox(const Draw& draw, uint64_t seed) {
    Random random = draw.random(seed);
    std::vector<Triangle> triangles = randomCutBox(random, dvec3(0.1, 0.2, 0.3), 3.0, 4).triangles();
    for (const Triangle& t : sphere(12, 0.7, dvec3(0.1, 0.2, 0.3))) triangles.push_back(t);
    return triangles;
}

vec3 pointIn(const Box& box, Random& random) {
    return vec3(glm::mix(dvec3(box.lo), dvec3(box.hi), dvec3(random.unit(), random.unit(), random.unit())));
}

/// Rays by a function of (bounds, random).
template <class MakeRay>
Scene sceneOf(const Draw& draw, const char* name, std::vector<Triangle> triangles, uint64_t seed, size_t count,
              MakeRay ray) {
    Scene scene{name, std::move(triangles), {}, false, 0.02};
    const Box box = boundsOf(scene.triangles);
    Random random = draw.random(seed);
    for (size_t i = 0; i < draw.rays(count); ++i) scene.rays.push_back(ray(box, random));
    return scene;
}

/// From around the box at a point in it.
Ray inwards(const Box& box, Random& random) {
    const vec3 target = pointIn(box, random);
    const double size = glm::length(dvec3(box.extent()));
    const vec3 origin = vec3(dvec3(box.centre()) + size * random.within(0.6, 2.0) * random.direction());
    return {origin, 0.0f, vec3(dvec3(target) - dvec3(origin)), inf};
}

/// Case 32: rays that enter the bounds anywhere, or begin on their far sides.
std::vector<Scene> entering(const Draw& draw) {
    return {sceneOf(draw, "generic", sphereInBox(draw, 1), 51, 800, inwards),
            sceneOf(draw, "from the farthest faces", sphere(10, 1.0, dvec3(0.1, 0.2, 0.3)), 52, 800,
                    [](const Box& box, Random& random) {
                        Ray ray{pointIn(box, random), 0.0f, vec3(0), inf};
                        const auto axis = static_cast<int>(random.below(3));
                        ray.origin[axis] = box.hi[axis];
                        ray.direction = vec3(dvec3(box.centre()) + 0.7 * random.direction() - dvec3(ray.origin));
                        return ray;
                    })};
}

/// Cases 33 and 34: with so many zeros of either sign.
std::vector<Scene> withZeros(const Draw& draw, int zeros) {
    return {sceneOf(draw, zeros == 1 ? "one zero" : "two zeros", sphereInBox(draw, 2), 53, 1500,
                    [zeros](const Box& box, Random& random) {
                        Ray ray = inwards(box, random);
                        const auto axis = static_cast<int>(random.below(3));
                        for (int i = 0; i < zeros; ++i) {
                            const int zero = (axis + i) % 3;
                            ray.origin[zero] += ray.direction[zero];
                            ray.direction[zero] = anyZero(random);
                        }
                        return ray;
                    })};
}

/// Case 36: from a plane of 2 to 16 cells, towards lower numbers.
std::vector<Scene> fromBoundaries(const Draw& draw) {
    return {sceneOf(draw, "backwards", sphereInBox(draw, 3), 54, 1500, [](const Box& box, Random& random) {
        Ray ray{pointIn(box, random), 0.0f, vec3(random.direction()), inf};
        const auto axis = static_cast<int>(random.below(3));
        const auto cells = static_cast<float>(2 + random.below(15));
        const auto number = static_cast<float>(1 + random.below(static_cast<uint32_t>(cells) - 1));
        ray.origin[axis] = box.lo[axis] + number * (box.extent()[axis] / cells);
        ray.direction[axis] = -std::abs(ray.direction[axis]);
        return ray;
    })};
}

/// Case 37: from so many sizes of the scene away, at the middle of what is seen. Its triangles are larger than what rounding
/// moves a ray by, even there.
std::vector<Scene> fromAfar(const Draw& draw) {
    std::vector<Scene> scenes;
    for (const double distance : {1e3, 1e4, 1e5})
        scenes.push_back(sceneOf(draw,
                                 distance < 5e3   ? "1e3"
                                 : distance < 5e4 ? "1e4"
                                                  : "1e5",
                                 sphere(4, 1.0, dvec3(0.1, 0.2, 0.3)), 55, 600, [distance](const Box&, Random& random) {
                                     const dvec3 direction = random.direction(),
                                                 target = dvec3(0.1, 0.2, 0.3) + 0.3 * random.direction();
                                     return Ray{vec3(target - distance * direction), 0.0f, vec3(direction), inf};
                                 }));
    for (Scene& scene : scenes) scene.mostOpen = scene.name == "1e5" ? 0.5 : 0.02;
    return scenes;
}

/// Case 38: 1e5 off the origin, where floats are 1/128 apart and cells of a 64th may lie; from inside.
std::vector<Scene> atOffset(const Draw& draw) {
    Random random = draw.random(56);
    CutBox box;
    for (size_t axis = 0; axis < 3; ++axis)
        for (int i = 0; i <= 12; ++i)
            box.cuts[axis].push_back(1e5f + static_cast<float>(4 * i + static_cast<int>(random.below(3))) / 128.0f);
    return {sceneOf(draw, "from inside", box.triangles(), 57, 1500, [&](const Box& bounds, Random& random_) {
        const vec3 origin = bounds.lo + vec3(glm::floor(dvec3(random_.inCube(4, 44)))) / 128.0f;
        if (random_.below(2) == 0) return Ray{origin, 0.0f, vec3(random_.direction()), inf};
        vec3 target;
        for (int axis = 0; axis < 3; ++axis) target[axis] = box.cuts[static_cast<size_t>(axis)][random_.below(13)];
        return Ray{origin, 0.0f, target == origin ? vec3(1) : target - origin, inf};
    })};
}

/// Case 39: walls within two steps of a float of where cells' faces lie, if there are n cells along an axis, n no power of
/// two.
std::vector<Scene> nearFaces(const Draw& draw) {
    std::vector<Scene> scenes;
    for (const int cells : {3, 5, 7, 12}) {
        Random random = draw.random(58);
        const Box box{vec3(-1.3f, -0.7f, -1.1f), vec3(1.7f, 2.3f, 1.9f)};
        std::vector<Triangle> walls = {{box.lo, box.hi, vec3(box.lo.x, box.hi.y, box.lo.z)}};
        for (int i = 0; i < 300; ++i) {
            const auto axis = static_cast<int>(random.below(3));
            const auto number = static_cast<float>(random.below(static_cast<uint32_t>(cells) + 1));
            float at = box.lo[axis] + number * ((box.hi[axis] - box.lo[axis]) / static_cast<float>(cells));
            const int steps = static_cast<int>(random.below(5)) - 2;
            for (int k = 0; k < std::abs(steps); ++k) at = std::nextafter(at, steps < 0 ? -inf : inf);
            at = std::clamp(at, box.lo[axis], box.hi[axis]);
            Triangle wall{pointIn(box, random), pointIn(box, random), pointIn(box, random)};
            for (vec3* corner : {&wall.a, &wall.b, &wall.c}) (*corner)[axis] = at;
            walls.push_back(wall);
        }
        scenes.push_back(sceneOf(draw, "walls", walls, 59, 500, [](const Box& bounds, Random& random_) {
            return Ray{pointIn(bounds, random_), 0.0f, vec3(random_.direction()), inf};
        }));
        scenes.back().name = fmt::format("{} cells", cells);
    }
    return scenes;
}

/// Case 40: triangles as large as the scene, that lie in most cells, with small ones before and behind them.
std::vector<Scene> largeOnes(const Draw& draw) {
    std::vector<Triangle> triangles;
    Random random = draw.random(60);
    for (int i = 0; i < 30; ++i) triangles.push_back({random.inCube(-1, 1), random.inCube(-1, 1), random.inCube(-1, 1)});
    for (int i = 0; i < 1000; ++i) {
        const vec3 at = random.inCube(-1, 1);
        triangles.push_back({at, at + 0.05f * random.inCube(-1, 1), at + 0.05f * random.inCube(-1, 1)});
    }
    return {sceneOf(draw, "large and small", triangles, 61, 1500, inwards)};
}

/// Case 41: the teapot in the stadium.
std::vector<Scene> stadium(const Draw& draw) {
    std::vector<Triangle> triangles = sphere(16, 1.0, dvec3(0), 0.1);
    CutBox place;
    for (std::vector<float>& cuts : place.cuts) cuts = {-1000.0f, 1000.0f};
    for (const Triangle& t : place.triangles()) triangles.push_back(t);
    return {sceneOf(draw, "sphere in a box 1,000 times as large", triangles, 62, 1000, [](const Box&, Random& random) {
        const vec3 origin = vec3(random.within(2.0, 600.0) * random.direction());
        return Ray{origin, 0.0f, vec3(0.9 * random.direction() - dvec3(origin)), inf};
    })};
}

/// Case 42: long slivers along diagonals.
std::vector<Scene> diagonals(const Draw& draw) {
    std::vector<Triangle> triangles;
    Random random = draw.random(63);
    for (int i = 0; i < 10'000; ++i) {
        const dvec3 at = random.inCube(-1, 0),
                    along(random.within(0.8, 1.2), random.within(0.8, 1.2), random.within(0.8, 1.2));
        triangles.push_back({vec3(at), vec3(at + along), vec3(at + along + 1e-3 * random.direction())});
    }
    std::vector<Scene> scenes{sceneOf(draw, "10,000 slivers", triangles, 64, 150, inwards)};
    scenes[0].mostOpen = 0.2;
    return scenes;
}

/// Case 43: no extent along an axis, or along two.
std::vector<Scene> flatScenes(const Draw& draw) {
    const char* const floorNames[] = {"a floor across x", "a floor across y", "a floor across z"};
    const char* const stripNames[] = {"a strip across x", "a strip across y", "a strip across z"};
    std::vector<Scene> scenes;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Triangle> floor = squares(axis, 0.7f, 16);
        const auto slantwise = [axis](const Box& box, Random& random) {
            Ray ray = inwards(box, random);
            if (random.below(4) == 0) ray.origin = pointIn(box, random);  // in the floor
            if (std::abs(ray.direction[axis]) < 0.05f) ray.direction[axis] = 0.05f;
            return ray;
        };
        scenes.push_back(sceneOf(draw, floorNames[axis], floor, 65, 400, slantwise));
        for (Triangle& t : floor)  // a strip of 1 x 16
            for (vec3* corner : {&t.a, &t.b, &t.c}) (*corner)[(axis + 1) % 3] *= 1e-3f;
        scenes.push_back(sceneOf(draw, stripNames[axis], floor, 66, 400, slantwise));
        for (size_t i = 0; i < 2; ++i) scenes[scenes.size() - 2 + i].mostOpen = 0.5;  // in the floor: t = 0
    }
    return scenes;
}

/// Case 44 and 45: triangles around one vertex; copies of one.
std::vector<Scene> growing(const Draw& draw, bool identical) {
    std::vector<Triangle> triangles;
    Random random = draw.random(67);
    const dvec3 shared(0.1, 0.2, 0.3);
    for (int i = 0; i < 1000; ++i) {
        const dvec3 b = random.inCube(-1, 1), c = random.inCube(-1, 1);
        triangles.push_back({vec3(shared), vec3(b), vec3(c)});
        if (identical) triangles.back() = triangles.front();
    }
    Scene scene =
        sceneOf(draw, identical ? "copies" : "around a vertex", triangles, 68, 400, [&](const Box& box, Random& random_) {
            Ray ray = inwards(box, random_);
            if (random_.below(2) == 0) ray.direction = vec3(shared + 1e-3 * random_.direction() - dvec3(ray.origin));
            return ray;
        });
    scene.mostOpen = identical ? 0.02 : 0.6;  // their other edges are nobody else's
    return {scene};
}

/// Walls in all planes of whole numbers from 0 to 4: 64 closed rooms.
std::vector<Triangle> rooms() {
    std::vector<Triangle> walls;
    for (int axis = 0; axis < 3; ++axis)
        for (int place = 0; place <= 4; ++place)
            for (const Triangle& t : squares(axis, static_cast<float>(place), 4)) walls.push_back(t);
    return walls;
}

/// Cases 47 to 49. Slopes are powers of two, places quarters: nothing rounds that decides a hit, unless an interval begins
/// or ends there and the ray is along no axis.
std::vector<Scene> inRooms(const Draw& draw, int number) {
    Scene scene{"rooms", rooms(), {}, true, 0.0};
    Random random = draw.random(static_cast<uint64_t>(number));
    const auto whole = [&] { return static_cast<float>(random.below(5)); };
    const auto quarter = [&] { return static_cast<float>(random.below(17)) / 4.0f; };
    while (scene.rays.size() < draw.rays(1500)) {
        const auto axis = static_cast<int>(random.below(3));
        const int other = (axis + 1 + static_cast<int>(random.below(2))) % 3, third = 3 - axis - other;
        Ray ray{vec3(quarter(), quarter(), quarter()), 0.0f, vec3(0.0f), inf};
        ray.direction[axis] = random.below(2) == 0 ? 1.0f : -1.0f;
        ray.direction[other] = anyZero(random);
        ray.direction[third] = anyZero(random);
        if (number != 49)
            ray.direction[third] = std::ldexp(random.below(2) == 0 ? 1.0f : -1.0f, -static_cast<int>(random.below(4)));
        if (number == 48) ray.origin[other] = whole();  // in a plane, in which walls lie
        if (number == 47 && random.below(2) == 0) ray.direction[other] = 0.25f;
        if (random.below(2) == 0) ray.origin -= 8.0f * ray.direction;  // from outside
        if (number == 49) {
            ray.origin[axis] = whole();
            if (random.below(2) == 0) ray.origin[other] = whole();
            const float step = static_cast<float>(random.below(4));
            (random.below(2) == 0 ? ray.tMin : ray.tMax) = step;
        }
        scene.rays.push_back(ray);
    }
    return {scene};
}

}  // namespace

std::vector<Case> cellCases() {
    return {
        {32, "where rays enter the bounds", entering},
        {33, "one zero", [](const Draw& draw) { return withZeros(draw, 1); }},
        {34, "two zeros", [](const Draw& draw) { return withZeros(draw, 2); }},
        {36, "from a boundary, backwards", fromBoundaries},
        {37, "from far away", fromAfar},
        {38, "far off the origin", atOffset},
        {39, "walls next to the faces of cells", nearFaces},
        {40, "large triangles in many cells", largeOnes},
        {41, "a teapot in a stadium", stadium},
        {42, "diagonal slivers", diagonals},
        {43, "flat scenes", flatScenes},
        {44, "1,000 triangles around a vertex", [](const Draw& draw) { return growing(draw, false); }},
        {45, "1,000 copies of a triangle", [](const Draw& draw) { return growing(draw, true); }},
        {47, "walls in the planes that cut space", [](const Draw& draw) { return inRooms(draw, 47); }},
        {48, "rays in the planes that cut space", [](const Draw& draw) { return inRooms(draw, 48); }},
        {49, "origins and ends of rays in these planes", [](const Draw& draw) { return inRooms(draw, 49); }},
    };
}

}  // namespace raig::hard

// Cases 1 to 12: rays that meet boxes in their faces, edges and corners. What is hit are the cut faces of closed boxes: the
// boxes around their triangles, and around groups of them, have their sides in the cuts.
#include "measure/hard_cases.hpp"
#include "measure/hard_meshes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace raig::hard {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

/// Boxes that do not touch, in cells of size `pitch`.
struct City {
    std::vector<CutBox> boxes;
    std::vector<Triangle> triangles;
    double pitch;
    dvec3 centre;
};

City city(const Draw& draw, uint64_t seed, int side, double pitch, const dvec3& centre, int inner = 3) {
    Random random = draw.random(seed);
    City result{{}, {}, pitch, centre};
    for (int i = 0; i < side * side * side; ++i) {
        const dvec3 cell(i % side, i / side % side, i / (side * side));
        result.boxes.push_back(randomCutBox(random, centre + pitch * (cell - 0.5 * (side - 1.0)), 0.8 * pitch, inner));
        for (const Triangle& t : result.boxes.back().triangles()) result.triangles.push_back(t);
    }
    return result;
}

/// A place on a face, and which way the face looks.
struct Place {
    vec3 at;
    int axis;
    float outwards;
};

/// A point of a face of a box, with `onCuts` of its two coordinates on inner cuts and the others between them.
Place placeOnFace(const CutBox& box, Random& random, uint32_t onCuts) {
    Place place{vec3(0.0f), static_cast<int>(random.below(3)), random.below(2) == 0 ? -1.0f : 1.0f};
    const uint32_t first = random.below(2);
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float>& cuts = box.cuts[static_cast<size_t>(axis)];
        if (axis == place.axis) {
            place.at[axis] = place.outwards < 0.0f ? cuts.front() : cuts.back();
        } else {
            const bool isFirst = (axis == (place.axis + 1) % 3) == (first == 0);
            const auto inner = static_cast<uint32_t>(cuts.size()) - 2;
            place.at[axis] = onCuts == 2 || (onCuts == 1 && isFirst)
                                 ? cuts[1 + random.below(inner)]
                                 : static_cast<float>(random.within(cuts[1], cuts[inner]));
        }
    }
    return place;
}

const CutBox& anyBox(const City& city, Random& random) {
    return city.boxes[random.below(static_cast<uint32_t>(city.boxes.size()))];
}

/// From outside the face, at a slant.
vec3 originBefore(const Place& place, const City& city, Random& random) {
    dvec3 from = random.direction();
    from[place.axis] = place.outwards * (std::abs(from[place.axis]) + 0.3);
    return vec3(dvec3(place.at) + city.pitch * random.within(0.1, 2.0) * from);
}

/// Makes rays of `ray(place, random)` at places with so many coordinates on cuts.
template <class MakeRay>
Scene sceneOf(const Draw& draw, const char* name, const City& city, uint64_t seed, uint32_t onCuts, MakeRay ray) {
    Scene scene{name, city.triangles, {}, false, 0.03};
    Random random = draw.random(seed);
    while (scene.rays.size() < draw.rays(800))
        scene.rays.push_back(ray(placeOnFace(anyBox(city, random), random, onCuts), random));
    return scene;
}

/// Cases 1 and 2: along an axis, in the planes of one or two faces of boxes.
std::vector<Scene> alongFaces(const Draw& draw, uint32_t onCuts) {
    const City boxes = city(draw, 1, 3, 1.0, dvec3(0.3, -0.2, 0.1));
    return {sceneOf(draw, "axis rays", boxes, 11 + onCuts, onCuts, [&](const Place& place, Random& random) {
        Ray ray{place.at, 0.0f, vec3(anyZero(random), anyZero(random), anyZero(random)), inf};
        ray.direction[place.axis] = -place.outwards;
        ray.origin[place.axis] += place.outwards * static_cast<float>(random.within(0.05, 5.0));
        return ray;
    })};
}

/// Cases 3 and 4: one component that is a zero; of either sign, or -0.
std::vector<Scene> withAZero(const Draw& draw, bool onlyNegative) {
    const City boxes = city(draw, 2, 3, 1.0, dvec3(0.3, -0.2, 0.1));
    return {sceneOf(draw, "one zero", boxes, onlyNegative ? 14 : 13, 1, [&](const Place& place, Random& random) {
        Ray ray{originBefore(place, boxes, random), 0.0f, vec3(0.0f), inf};
        const int zero = (place.axis + 1 + static_cast<int>(random.below(2))) % 3;
        ray.origin[zero] = place.at[zero];
        ray.direction = place.at - ray.origin;
        ray.direction[zero] = onlyNegative ? -0.0f : anyZero(random);
        return ray;
    })};
}

/// Cases 5, 6 and 8: at corners of boxes, with d = corner - o, times `scale`.
std::vector<Scene> atCorners(const Draw& draw, double pitch, const dvec3& centre, double scale) {
    const City boxes = city(draw, 3, 3, pitch, centre);
    return {sceneOf(draw, "corners", boxes, 15, 2, [&](const Place& place, Random& random) {
        Ray ray{originBefore(place, boxes, random), 0.0f, vec3(0.0f), inf};
        ray.direction = vec3(dvec3(place.at - ray.origin) * scale);
        return ray;
    })};
}

/// Case 7: 1e6 away, at slopes of 1e-6.
std::vector<Scene> fromFarAway(const Draw& draw) {
    const City boxes = city(draw, 4, 1, 60.0, dvec3(0), 2);
    return {sceneOf(draw, "slope 1e-6", boxes, 17, 0, [&](const Place& place, Random& random) {
        dvec3 direction = 1e-6 * random.direction();
        direction[place.axis] = -place.outwards;
        return Ray{vec3(dvec3(place.at) - 1e6 * direction), 0.0f, vec3(direction), inf};
    })};
}

/// A floor of 16 x 16 squares across `axis`, between 1.5 and 17.5 times `scale`.
std::vector<Triangle> floorOf(int axis, float height) {
    std::vector<Triangle> floor = squares(axis, height, 16);
    for (Triangle& t : floor)
        for (vec3* corner : {&t.a, &t.b, &t.c}) {
            *corner += vec3(1.5f);
            (*corner)[axis] = height;
        }
    return floor;
}

/// Case 9: a floor without thickness, seen at a slant; away from its rim, beyond which there is nothing.
std::vector<Scene> atFloors(const Draw& draw) {
    std::vector<Scene> scenes;
    for (int axis = 0; axis < 3; ++axis) {
        Scene scene{fmt::format("floor across {}", "xyz"[axis]), floorOf(axis, 2.25f), {}, false, 0.0};
        Random random = draw.random(19);
        while (scene.rays.size() < draw.rays(300)) {
            vec3 at = vec3(dvec3(random.inCube(2.5, 16.5)));
            if (random.below(2) == 0) at = glm::floor(at) + 0.5f;  // a corner of squares
            at[axis] = 2.25f;
            dvec3 from = random.direction();
            from[axis] += from[axis] < 0.0 ? -0.2 : 0.2;
            const vec3 origin = vec3(dvec3(at) + 10.0 * random.unit() * from + 0.1 * from);
            scene.rays.push_back({origin, 0.0f, vec3(dvec3(at) - dvec3(origin)), inf});
        }
        scenes.push_back(scene);
    }
    return scenes;
}

/// Case 10: a component that is denormal.
std::vector<Scene> withDenormals(const Draw& draw) {
    const City boxes = city(draw, 5, 3, 1.0, dvec3(0.3, -0.2, 0.1));
    return {sceneOf(draw, "1e-40", boxes, 20, 1, [&](const Place& place, Random& random) {
        Ray ray{originBefore(place, boxes, random), 0.0f, vec3(0.0f), inf};
        const int small = (place.axis + 1 + static_cast<int>(random.below(2))) % 3;
        ray.origin[small] = place.at[small];
        ray.direction = place.at - ray.origin;
        ray.direction[small] = static_cast<float>((random.below(2) == 0 ? 1e-40 : -1e-40) * random.within(0.01, 10.0));
        return ray;
    })};
}

/// Case 11: axis rays at a floor, with origins beyond 1.
std::vector<Scene> axisRaysAtFloors(const Draw& draw) {
    std::vector<Scene> scenes;
    for (int axis = 0; axis < 3; ++axis) {
        Scene scene{fmt::format("floor across {}", "xyz"[axis]), floorOf(axis, 0.75f), {}, false, 0.0};
        Random random = draw.random(21);
        while (scene.rays.size() < draw.rays(300)) {
            Ray ray{vec3(dvec3(random.inCube(2.5, 16.5))), 0.0f, vec3(anyZero(random), anyZero(random), anyZero(random)),
                    inf};
            if (random.below(2) == 0) ray.origin = glm::floor(ray.origin) + 0.5f;
            const float side = random.below(2) == 0 ? 1.0f : -1.0f;
            ray.direction[axis] = -side;
            ray.origin[axis] = 0.75f + side * static_cast<float>(random.within(1.0, 9.0));
            scene.rays.push_back(ray);
        }
        scenes.push_back(scene);
    }
    return scenes;
}

/// Case 12: boxes in boxes, on sixteenths; along an axis, from a side, or until one.
std::vector<Scene> nested(const Draw& draw) {
    Scene scene{"nested boxes", {}, {}, true, 0.0};
    std::vector<CutBox> boxes;
    for (int i = 1; i <= 6; ++i) {
        CutBox box;
        for (std::vector<float>& cuts : box.cuts)
            for (const int at : {-4, -1, 2, 4}) cuts.push_back(static_cast<float>(at * i) / 16.0f);
        boxes.push_back(box);
        for (const Triangle& t : box.triangles()) scene.triangles.push_back(t);
    }
    Random random = draw.random(22);
    while (scene.rays.size() < draw.rays(1500)) {
        const auto aSixteenth = [&] { return (static_cast<float>(random.below(49)) - 24.0f) / 16.0f; };
        const auto aSide = [&] { return static_cast<float>(1 + random.below(6)) / (random.below(2) == 0 ? 4.0f : -4.0f); };
        const auto axis = static_cast<int>(random.below(3));
        Ray ray{vec3(aSixteenth(), aSixteenth(), aSixteenth()), 0.0f,
                vec3(anyZero(random), anyZero(random), anyZero(random)), inf};
        if (random.below(2) == 0) ray.origin += 1.0f / 32.0f;  // on no cut
        const float speed = random.below(2) == 0 ? 0.5f : 1.0f;
        ray.direction[axis] = random.below(2) == 0 ? speed : -speed;
        if (random.below(2) == 0) ray.origin[axis] = aSide();
        for (float* end : {&ray.tMin, &ray.tMax}) {
            const float t = (aSide() - ray.origin[axis]) / ray.direction[axis];
            if (random.below(3) == 0 && t >= 0.0f) *end = t;
        }
        scene.rays.push_back(ray);
    }
    return {scene};
}

}  // namespace

std::vector<Case> boxCases() {
    return {
        {1, "an axis ray in the plane of a box's face", [](const Draw& draw) { return alongFaces(draw, 1); }},
        {2, "a ray along a box's edge", [](const Draw& draw) { return alongFaces(draw, 2); }},
        {3, "one component +0 or -0", [](const Draw& draw) { return withAZero(draw, false); }},
        {4, "one component -0", [](const Draw& draw) { return withAZero(draw, true); }},
        {5, "aimed at a box's corner", [](const Draw& draw) { return atCorners(draw, 1.0, dvec3(0.3, -0.2, 0.1), 1.0); }},
        {6, "aimed at a box's corner, 1e6 off the origin",
         [](const Draw& draw) { return atCorners(draw, 100.0, dvec3(1e6, -1e6, 1e6), 1.0); }},
        {7, "slope 1e-6, from 1e6 away", fromFarAway},
        {8, "a direction of length 1e-13",
         [](const Draw& draw) { return atCorners(draw, 1.0, dvec3(0.3, -0.2, 0.1), 1e-13); }},
        {9, "flat nodes", atFloors},
        {10, "a denormal component", withDenormals},
        {11, "axis rays at a floor, origins beyond 1", axisRaysAtFloors},
        {12, "nested boxes, origins and ends on their sides", nested},
    };
}

}  // namespace raig::hard

#include "support/sphere_soups.hpp"

#include <limits>

namespace raig::test {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

std::vector<Primitive> randomSpheres(uint64_t seed, size_t count) {
    Random random(seed);
    std::vector<Primitive> spheres;
    for (size_t i = 0; i < count; ++i) {
        const vec3 centre = random.inCube(-1, 1);
        spheres.push_back(Primitive::sphere(centre, static_cast<float>(std::pow(10.0, random.within(-3.0, -0.7)))));
    }
    return spheres;
}

std::vector<Primitive> moved(std::vector<Primitive> spheres, double scale, dvec3 offset) {
    for (Primitive& s : spheres) {
        const auto radius = static_cast<float>(scale * s.radius());
        s = Primitive::sphere(vec3(dvec3(s.centre()) * scale + offset), radius);
    }
    return spheres;
}

/// Shells around some centres, 4e-5 apart, in no order.
std::vector<Primitive> nested(size_t centres, size_t shells) {
    Random random(21);
    std::vector<Primitive> spheres;
    for (size_t i = 0; i < centres; ++i) {
        const vec3 centre = random.inCube(-1, 1);
        for (size_t j = 0; j < shells; ++j)
            spheres.push_back(Primitive::sphere(centre, 0.4f + 4e-5f * static_cast<float>(j * 7 % shells)));
    }
    return spheres;
}

/// Equal spheres that touch each other, in a lattice of exact numbers.
std::vector<Primitive> tangent(int side) {
    std::vector<Primitive> spheres;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z) spheres.push_back(Primitive::sphere(0.5f * vec3(x, y, z) - 0.75f, 0.25f));
    return spheres;
}

std::vector<Primitive> withUnusable() {
    std::vector<Primitive> spheres = randomSpheres(23, 160);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const vec3 p(0.5f, 0.25f, -0.5f);
    const std::vector<Primitive> bad = {Primitive::sphere(p, 0.0f),         Primitive::sphere(p, -0.5f),
                                        Primitive::sphere(p, nan),          Primitive::sphere(p, inf),
                                        Primitive::sphere(vec3(nan), 0.5f), Primitive::sphere(vec3(0, inf, 0), 0.5f),
                                        Primitive::sphere(p, 1.9e18f),      Primitive::sphere(vec3(1.8e18f), 1e17f)};
    for (size_t i = 0; i < bad.size(); ++i) spheres.insert(spheres.begin() + static_cast<long>(i * 20), bad[i]);
    return spheres;
}

/// Triangles of a mesh, spheres of all sizes in front of and in it, and one that is the ground; triangles and spheres in
/// turn.
std::vector<Primitive> mixed() {
    std::vector<Primitive> primitives;
    const std::vector<Triangle> mesh = sphere(8, 0.6, dvec3(0), 0.2);
    const std::vector<Primitive> balls = randomSpheres(24, 120);
    for (size_t i = 0; i < std::max(mesh.size(), balls.size()); ++i) {
        if (i < mesh.size()) primitives.push_back(mesh[i]);
        if (i < balls.size()) primitives.push_back(balls[i]);
    }
    primitives.push_back(Primitive::sphere(vec3(0, -101, 0), 100.0f));
    return primitives;
}

/// Of radii below the last place of their centres, and one that gives the scene its size.
std::vector<Primitive> dust() {
    Random random(25);
    std::vector<Primitive> spheres{Primitive::sphere(vec3(0), 0.75f)};
    for (int i = 0; i < 100; ++i)
        spheres.push_back(
            Primitive::sphere(random.inCube(-1, 1), static_cast<float>(std::pow(10.0, random.within(-30, -6)))));
    spheres.push_back(Primitive::sphere(vec3(0), 1e-25f));
    return spheres;
}

}  // namespace

std::vector<Soup> sphereSoups() {
    const std::vector<Primitive> ordinary = randomSpheres(20, 300);
    const Primitive one = Primitive::sphere(vec3(0.1f, -0.2f, 0.3f), 0.7f);
    return {
        {"one sphere", {one}},
        {"spheres", ordinary},
        {"nested spheres", nested(3, 20)},
        {"tangent spheres", tangent(4)},
        {"same spheres", std::vector<Primitive>(100, one)},
        {"unusable spheres", withUnusable()},
        {"spheres and triangles", mixed()},
        {"dust", dust()},
        {"far spheres", moved(ordinary, 1.0, dvec3(1e4, -2e4, 3e4))},
        {"tiny spheres", moved(ordinary, 2e-13, dvec3(0))},
        {"huge spheres", moved(ordinary, 2e9, dvec3(0))},
    };
}

vec3 pointOnSphere(const Primitive& sphere, Random& random) {
    return vec3(dvec3(sphere.centre()) + double{sphere.radius()} * random.direction());
}

Ray rayAtSphere(const Primitive& sphere, Random& random) {
    const dvec3 centre(sphere.centre());
    const double r = sphere.radius();
    const dvec3 outwards = random.direction();
    // From the surface, from inside, from outside, from far away.
    static constexpr double nearest[] = {0.0, -9.0, -2.0, 0.0}, farthest[] = {0.0, 0.0, 1.0, 6.0};
    const uint32_t family = random.below(4);
    double distance = r;
    if (family == 1) distance = r * random.unit();
    if (family >= 2) distance = r * (1.0 + std::pow(10.0, random.within(nearest[family], farthest[family])));
    const vec3 origin = vec3(centre + distance * outwards);
    dvec3 target = centre;  // through it
    const dvec3 aside = glm::normalize(glm::cross(outwards, random.direction()));
    switch (random.below(4)) {
        case 0:
            break;
        case 1:
            target = dvec3(pointOnSphere(sphere, random));
            break;
        default: {  // past the silhouette, or along the surface, by some units in the last place
            const double sine = distance > r ? r / distance : 1.0, cosine = std::sqrt(1.0 - sine * sine);
            target = centre + r * (sine * outwards + cosine * aside);
            if (distance <= r) target = dvec3(origin) + r * aside;
            target += std::pow(10.0, random.within(-9, -6)) * r * random.direction();
            break;
        }
    }
    dvec3 direction = target - dvec3(origin);
    const double length = glm::length(direction);
    if (!(length > 0.0)) direction = aside;
    if (length > 0.0 && random.below(2) == 0) direction /= length;
    return {origin, 0.0f, vec3(direction), inf};
}

}  // namespace raig::test

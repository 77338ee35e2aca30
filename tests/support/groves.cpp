#include "support/groves.hpp"

#include "base/random.hpp"
#include "measure/hard_meshes.hpp"
#include "support/soups.hpp"

namespace raig::test {

namespace {

dmat4 translation(const dvec3& by) {
    dmat4 m(1.0);
    m[3] = dvec4(by, 1.0);
    return m;
}

dmat4 scaling(const dvec3& s) {
    return dmat4(dvec4(s.x, 0, 0, 0), dvec4(0, s.y, 0, 0), dvec4(0, 0, s.z, 0), dvec4(0, 0, 0, 1));
}

dmat4 rotation(Random& random) {
    const dvec3 x = random.direction();
    const dvec3 y = glm::normalize(glm::cross(x, random.direction()));
    return dmat4(dvec4(x, 0), dvec4(y, 0), dvec4(glm::cross(x, y), 0), dvec4(0, 0, 0, 1));
}

dmat4 shear(Random& random) {
    dmat4 m(1.0);
    m[1].x = random.within(-1.5, 1.5);
    m[2].y = random.within(-1.5, 1.5);
    return m;
}

/// Ordinary triangles, with a few that none can hit.
std::vector<Triangle> shreds(Random& random, size_t count) {
    std::vector<Triangle> triangles;
    for (size_t i = 0; i < count; ++i) {
        const vec3 at = random.inCube(-1, 1);
        triangles.push_back({at, at + 0.4f * random.inCube(-1, 1), at + 0.4f * random.inCube(-1, 1)});
    }
    triangles[0].b = triangles[0].a;
    triangles[1].c.x = std::numeric_limits<float>::quiet_NaN();
    return triangles;
}

Scene startScene(uint64_t seed) {
    Random random(seed);
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes = {hard::meshOf(sphere(5, 1.0, dvec3(0), 0.1)), hard::meshOf(shreds(random, 30)),
                    hard::meshOf(sphere(3, 0.7, dvec3(0.2)))};
    return scene;
}

/// Adds `count` instances of meshes 0 and 1 around `centre`, of sizes in [least, most], by all kinds of transforms.
void plant(Scene& scene, Random& random, int count, const dvec3& centre, double reach, double least, double most) {
    for (int i = 0; i < count; ++i) {
        const double size = least * std::pow(most / least, random.unit());
        dmat4 m = translation(centre + reach * dvec3(random.inCube(-1, 1))) * rotation(random) * scaling(dvec3(size));
        if (i % 3 == 1) m = m * scaling({random.within(0.2, 3), random.within(0.2, 3), random.within(-3, 3)});
        if (i % 4 == 2) m = m * shear(random) * rotation(random);
        if (i % 5 == 3) m = m * scaling({-1, 1, 1});
        scene.instances.push_back({static_cast<uint32_t>(i % 2), m});
    }
}

Scene plainGrove(uint64_t seed, double size = 1.0, const dvec3& centre = dvec3(0)) {
    Scene scene = startScene(seed);
    Random random(seed + 1);
    plant(scene, random, 16, centre, 4.0 * size, 0.3 * size, 1.5 * size);
    scene.instances.push_back({2, translation(centre) * scaling(dvec3(size))});
    return scene;
}

Scene singularGrove() {
    Scene scene = plainGrove(31);
    for (const dvec3 s :
         {dvec3(0), dvec3(1, 1, 0), dvec3(1, 1, 1e-8), dvec3(1, 1e-4, 1e4), dvec3(1e-20, 1, 1), dvec3(1, 0.01, 1)})
        for (uint32_t mesh : {0u, 1u}) scene.instances.push_back({mesh, translation({1, 2, 3}) * scaling(s)});
    dmat4 nearlyFlat(1.0);
    nearlyFlat[2] = nearlyFlat[0] + nearlyFlat[1] + dvec4(0, 0, 1e-12, 0);
    scene.instances.push_back({0, nearlyFlat});
    return scene;
}

Scene displacedGrove() {
    Scene scene = startScene(41);
    for (Mesh& mesh : scene.meshes)
        for (vec3& p : mesh.positions) p += vec3(1000, -3000, 500);
    // Spheres, too: they are written out beside what is kept.
    Random random(42);
    for (int i = 0; i < 5; ++i)
        scene.meshes[1].spheres.push_back({vec3(1000, -3000, 500) + random.inCube(-1, 1), 0.1f + 0.1f * i});
    scene.meshes[1].materials.resize(scene.meshes[1].primitiveCount(), 0);
    for (uint32_t i = 0; i < 12; ++i)
        scene.instances.push_back(
            {i % 2, translation(3.0 * dvec3(random.inCube(-1, 1))) * rotation(random) * translation({-1000, 3000, -500})});
    return scene;
}

Scene sliverGrove() {
    Scene scene;
    scene.materials.emplace_back();
    Random random(51);
    std::vector<Triangle> slivers;
    for (int i = 0; i < 60; ++i) {
        const vec3 a = random.inCube(-1, 1), b = random.inCube(-1, 1);
        // Half of them lie on a line exactly, and would not once they are turned; the others nearly do, and may once moved
        // away.
        slivers.push_back(i % 2 == 0 ? Triangle{vec3(a.x, a.y, 0), vec3(b.x, a.y, 0), vec3(0.5f * (a.x + b.x), a.y, 0)}
                                     : Triangle{a, b, 0.5f * a + 0.5f * b + vec3(1e-6f, 0, 0)});
    }
    const std::vector<Triangle> ball = sphere(4, 1.0, dvec3(0), 0.1);
    slivers.insert(slivers.end(), ball.begin(), ball.end());
    scene.meshes.push_back(hard::meshOf(slivers));
    for (int i = 0; i < 10; ++i)
        scene.instances.push_back(
            {0, translation((i % 3 == 0 ? 50.0 : 2.0) * dvec3(random.inCube(-1, 1))) * rotation(random)});
    return scene;
}

Scene smallNumbersGrove() {
    Scene scene = startScene(61);
    // Rotations by quarters as programs compute them, and vertices that are all but zero.
    scene.meshes[0].positions[0] = vec3(1.0f, 1e-25f, -3e-39f);
    scene.meshes[0].positions[4].y = 1e-20f;
    scene.meshes[1].positions[7].z = 2e-30f;
    for (int i = 0; i < 8; ++i) {
        dmat4 quarter(1.0);
        quarter[0] = dvec4(std::cos(M_PI_2), std::sin(M_PI_2), 0, 0);
        quarter[1] = dvec4(-std::sin(M_PI_2), std::cos(M_PI_2), 1e-22, 0);
        scene.instances.push_back({static_cast<uint32_t>(i % 2), translation({2.5 * i - 9, i % 3, 1e-30}) * quarter});
    }
    return scene;
}

/// Triangles that are usable where the mesh is, and beyond all floats where it stands: on both sides of it, or on one.
Scene overflowingGrove(float far) {
    Scene scene;
    scene.materials.emplace_back();
    const float wide = 0x1p30f;
    Random random(91);
    std::vector<Triangle> triangles = {{vec3(0, 0, 0), vec3(0, wide, 0), vec3(0, 0, wide)},
                                       {vec3(0x1p29f, 0, 0), vec3(0x1p29f, 1e6f, 0), vec3(0x1p29f, 0, 1e6f)},
                                       {vec3(far, 0, 0), vec3(far, 1e6f, 0), vec3(far, 0, 1e6f)}};
    for (int i = 0; i < 40; ++i) {
        const float y = 0.02f * wide * static_cast<float>(i);
        triangles.push_back(
            {vec3(0, y, 0), vec3(0, y + 0.01f * wide, 0.1f * wide), vec3(0, y, static_cast<float>(random.unit()) * wide)});
    }
    scene.meshes.push_back(hard::meshOf(triangles));
    for (int i = 0; i < 3; ++i)
        scene.instances.push_back({0, translation({0, 268435456.0 * i, 0}) * scaling({0x1p100, 1, 1})});
    return scene;
}

}  // namespace

std::vector<Grove> groves() {
    std::vector<Grove> result;
    result.push_back({"plain", plainGrove(1)});
    Scene sizes = startScene(11);
    Random random(12);
    plant(sizes, random, 20, dvec3(0), 6.0, 1e-3, 8.0);
    sizes.instances.push_back(sizes.instances[3]);  // the same place twice: the lower id counts
    sizes.instances.push_back(sizes.instances[4]);
    result.push_back({"sizes", std::move(sizes)});
    result.push_back({"away", plainGrove(20, 1.0, {300, -20, 150})});
    result.push_back({"far", plainGrove(21, 1.0, {148376, 1234, -223423})});
    result.push_back({"tiny", plainGrove(22, 1e-13)});
    result.push_back({"huge", plainGrove(23, 1e15)});
    result.push_back({"singular", singularGrove()});
    result.push_back({"displaced", displacedGrove()});
    result.push_back({"slivers", sliverGrove()});
    result.push_back({"small numbers", smallNumbersGrove()});
    result.push_back({"overflowing", overflowingGrove(0x1p28f)});
    result.push_back({"overflowing both ways", overflowingGrove(-0x1p29f)});
    Scene lonely = startScene(71);
    for (uint32_t i = 0; i < 3; ++i) lonely.instances.push_back({i, translation(dvec3(i))});
    result.push_back({"each once", std::move(lonely)});
    result.push_back({"empty", startScene(81)});
    return result;
}

}  // namespace raig::test

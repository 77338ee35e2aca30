// Case 57: item buffers against traced first hits, where rasters are known to be wrong.
#include "base/random.hpp"
#include "measure/hard_pictures.hpp"
#include "measure/hard_scenes.hpp"
#include "measure/oracle.hpp"
#include "rays/lights.hpp"
#include "rays/primitives.hpp"

#include <fmt/format.h>

#include <cmath>

namespace raig::hard {

namespace {

constexpr double rounding = 4.0 * 0x1p-24;

/// Gives each primitive of the last mesh one of thirteen lights, so that pixels show which they are of.
void tellApart(raig::Scene& scene) {
    Mesh& mesh = scene.meshes.back();
    for (size_t i = 0; i < mesh.materials.size(); ++i) {
        mesh.materials[i] = static_cast<uint32_t>(scene.materials.size());
        scene.materials.push_back(glowing(float(1 + i % 13) / 16.0f));
    }
}

/// The radiance of what an exact ray meets, to `within`; where rounding may decide, any.
PictureScene drawn(std::string name, raig::Scene scene, double within = rounding) {
    PictureScene result{.name = std::move(name), .scene = std::move(scene), .sameBits = true, .isDrawn = true};
    result.options.assign(3, pictureOf(24, 18, 1));
    result.options[2].tilePixels = 50;
    const auto geometry = std::make_shared<Geometry>(flatten(result.scene));
    const auto oracle = std::make_shared<Oracle>(primitivesOf(*geometry));
    result.fault = [rayOf = pixelRays(result.scene), geometry, oracle, within, materials = result.scene.materials](
                       const Picture& picture, const FrameOptions& options, size_t pixel) -> std::string {
        const Ray ray = rayOf(options, pixel);
        const Hit hit = oracle->closest(ray);
        const double seen = picture.radiance[pixel].x;
        const double want = hit.primitive == NO_HIT ? 0.0 : materials[geometry->materials[hit.primitive]].emission.x;
        if (std::abs(seen - want) <= within || oracle->isOpen(ray)) return "";
        return fmt::format("{:.9g} instead of {:.9g}", seen, want);
    };
    return result;
}

/// A ball whose triangles are told apart, before a wall; all of it scaled and moved.
raig::Scene ballAndWall(uint32_t rings, double size, const dvec3& place) {
    raig::Scene scene;
    const auto at = [&](const dvec3& p) { return vec3(place + size * p); };
    addBall(scene, at({0.1, 0.05, -3}), static_cast<float>(0.9 * size), rings, glowing(1.0f));
    tellApart(scene);
    addQuad(scene, at({-2, -2, -5}), vec3(float(4 * size), 0, 0), vec3(0, float(4 * size), 0), glowing(1.0f));
    tellApart(scene);
    scene.cameras.push_back(cameraAt(at({0, 0, 0}), {0.02f, -0.01f, -1}, 0.8f));
    return scene;
}

PictureScene parallel() {
    raig::Scene scene = ballAndWall(24, 1.0, dvec3(0));
    scene.cameras[0].orthographic = true;
    scene.cameras[0].xmag = scene.cameras[0].ymag = 1.2f;
    return drawn("seen in parallel", std::move(scene));
}

/// In a box, of whose floor, just below the eye, some lies behind it; and with something nearer than is drawn.
PictureScene nearPlane() {
    raig::Scene scene;
    addBox(scene, {-1, -1e-4f, -2}, {1, 1, 2}, glowing(1.0f));
    tellApart(scene);
    addMesh(scene, {{1e-7f, 1e-7f, -1e-6f}, {2e-7f, 1e-7f, -1e-6f}, {1e-7f, 3e-7f, -1e-6f}}, {{0, 1, 2}}, glowing(1.5f));
    addMesh(scene, {{-0.4f, 0.2f, 1.0f}, {-0.3f, 0.1f, -1.5f}, {-0.2f, 0.3f, 0.5f}}, {{0, 1, 2}}, glowing(1.25f));
    scene.cameras.push_back(cameraAt({0, 0, 0}, {0, 0, -1}, 1.5f));
    return drawn("across the plane of the eye", std::move(scene));
}

/// Walls that coincide, the later one with the higher id; and nearly, in both orders: depths do not tell them apart.
PictureScene coplanar() {
    raig::Scene scene;
    for (int i = 0; i < 4; ++i) {
        const float x = -1.5f + 0.75f * float(i), z = -3.0f, apart = i < 2 ? 0.0f : 0x1p-21f;
        const vec3 u(0.7f, 0, 0.31f), v(0, 1.8f, -0.17f);
        addQuad(scene, {x, -0.9f, i == 3 ? z - apart : z}, u, v, glowing(0.5f));
        addQuad(scene, {x, -0.9f, i == 3 ? z : z - apart}, u, v, glowing(0.5f + 1.0f / 64));
    }
    scene.cameras.push_back(cameraAt({0, 0, 0}, {0, 0, -1}, 0.9f));
    return drawn("coplanar pairs", std::move(scene), 1.0 / 64 + rounding);
}

/// Far more triangles than pixels, and slivers between their centres.
PictureScene subPixel(const Draw& draw) {
    raig::Scene scene = ballAndWall(40, 1.0, dvec3(0));
    Random random = draw.random(570);
    std::vector<vec3> corners;
    std::vector<uvec3> slivers;
    for (uint32_t i = 0; i < 60; ++i) {
        const vec3 from = random.inCube(-1, 1) + vec3(0, 0, -2.2f), to = from + 2.0f * random.inCube(-1, 1);
        corners.insert(corners.end(), {from, to, to + vec3(1e-3f, 2e-3f, 0)});
        slivers.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    addMesh(scene, corners, slivers, glowing(1.0f));
    tellApart(scene);
    return drawn("triangles smaller than pixels", std::move(scene));
}

PictureScene spheres() {
    raig::Scene scene = ballAndWall(12, 1.0, dvec3(0));
    addSphere(scene, {-0.5f, 0.3f, -2.2f}, 0.3f, glowing(0.9f));
    addSphere(scene, {0.6f, -0.2f, -2.6f}, 0.7f, glowing(0.95f));
    addSphere(scene, {0, 0, 0}, 8.0f, glowing(1.1f));  // the eye is in it
    return drawn("spheres among triangles", std::move(scene));
}

Material matte(float shade) {
    Material m;
    m.baseColor = vec3(shade);
    m.roughness = 1.0f;
    return m;
}

/// Balls of 16,128 triangles, of which `behind` stand behind the eye, and then four before it.
raig::Scene manyBalls(uint32_t behind) {
    raig::Scene scene = whiteSky();
    addBall(scene, vec3(0), 1.0f, 64, matte(1.0f));
    Mesh& ball = scene.meshes.back();
    for (size_t i = 0; i < ball.materials.size(); ++i) {
        if (i % 97 == 0) scene.materials.push_back(matte(float(1 + i % 13) / 16.0f));
        ball.materials[i] = static_cast<uint32_t>(scene.materials.size() - 1);
    }
    scene.instances.clear();
    const auto place = [&](const dvec3& p) {
        dmat4 m(1.0);
        m[3] = dvec4(p, 1.0);
        scene.instances.push_back({0, m});
    };
    for (uint32_t i = 0; i < behind; ++i) place({3.0 * (i % 30), 0.0, 10.0 + 3.0 * (i / 30)});
    for (uint32_t i = 0; i < 4; ++i) place({-3.0 + 2.0 * i, 0.5 * (i % 2), -6.0 - 0.5 * i});
    scene.cameras.push_back(cameraAt({0, 0, 0}, {0, 0, -1}, 0.7f));
    return scene;
}

/// What is seen has ids from 2^24 on, that floats do not tell apart.
PictureScene manyIds() {
    PictureScene scene{.name = "more than 2^24 primitives", .scene = manyBalls(1050), .sameBits = true};
    scene.keepsInstances = scene.isDrawn = true;
    scene.options.assign(2, pictureOf(24, 18, 1));
    const raig::Scene few = manyBalls(0);
    const Geometry geometry = flatten(few);
    Structure structure = structureType("bvh").build(primitivesOf(geometry), {});
    markSeeThrough(few, geometry, structure);
    const auto want =
        std::make_shared<Picture>(renderPicture(few, geometry, *makeCpuTracer(structure), scene.options.front()));
    scene.fault = [want](const Picture& picture, const FrameOptions&, size_t pixel) -> std::string {
        const double seen = picture.radiance[pixel].x, wanted = want->radiance[pixel].x;
        return std::abs(seen - wanted) <= 1e-5 ? "" : fmt::format("{:.9g} instead of {:.9g}", seen, wanted);
    };
    return scene;
}

std::vector<PictureScene> items(const Draw& draw) {
    return {drawn("edges and silhouettes", ballAndWall(24, 1.0, dvec3(0))),
            drawn("the same, tiny", ballAndWall(24, 1e-12, dvec3(0))),
            drawn("the same, huge", ballAndWall(24, 1e12, dvec3(0))),
            drawn("the same, far away", ballAndWall(24, 1.0, dvec3(3e4, -2e4, 1e4))),
            parallel(),
            nearPlane(),
            coplanar(),
            subPixel(draw),
            spheres(),
            manyIds()};
}

}  // namespace

std::vector<PictureCase> itemCases() {
    return {{57, "item buffers against traced first hits", items}};
}

}  // namespace raig::hard

/// Scenes put together in tests, and pictures of them by every way there is.
#pragma once

#include "base/parallel.hpp"
#include "rays/frame.hpp"
#include "rays/lights.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"

#include <memory>

namespace raig::test {

/// Reflects diffusely.
inline Material matte(const vec3& color) {
    Material m;
    m.baseColor = color;
    return m;
}

/// Reflects as a mirror if it is not rough.
inline Material metal(const vec3& color, float roughness = 0.0f) {
    Material m;
    m.baseColor = color;
    m.metallic = 1.0f;
    m.roughness = roughness;
    return m;
}

/// Solid, smooth glass of that index of refraction.
inline Material glass(float ior, const vec3& color = vec3(1.0f)) {
    Material m;
    m.baseColor = color;
    m.roughness = 0.0f;
    m.transmission = 1.0f;
    m.ior = ior;
    m.thin = false;
    return m;
}

/// Glass that absorbs.
inline Material tintedGlass() {
    Material tinted = glass(1.5f);
    tinted.attenuationColor = vec3(0.4f, 0.9f, 0.6f);
    tinted.attenuationDistance = 0.7f;
    return tinted;
}

/// Black, and glows.
inline Material glowing(const vec3& emission) {
    Material m = matte(vec3(0.0f));
    m.emission = emission;
    return m;
}

/// Adds a mesh of its own, with one material, where it stands. Returns its index.
inline uint32_t addMesh(Scene& scene, std::vector<vec3> positions, std::vector<uvec3> triangles, const Material& material) {
    Mesh mesh;
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    mesh.materials.assign(mesh.triangles.size(), static_cast<uint32_t>(scene.materials.size()));
    scene.materials.push_back(material);
    scene.meshes.push_back(std::move(mesh));
    const auto index = static_cast<uint32_t>(scene.meshes.size() - 1);
    scene.instances.push_back({index, dmat4(1.0)});
    return index;
}

/// The parallelogram at `corner` between edges u and v; its front is where u, v and the viewer's side are right-handed.
inline uint32_t addQuad(Scene& scene, const vec3& corner, const vec3& u, const vec3& v, const Material& material) {
    return addMesh(scene, {corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}}, material);
}

/// A closed sphere of rings x 2 rings quads, faces outwards; with its exact normals if `smooth`.
inline uint32_t addSphere(Scene& scene, const vec3& centre, float radius, uint32_t rings, bool smooth,
                          const Material& material) {
    std::vector<vec3> directions;
    std::vector<uvec3> triangles;
    const uint32_t around = 2 * rings;
    for (uint32_t i = 0; i <= rings; ++i)
        for (uint32_t j = 0; j < around; ++j) {
            const double theta = M_PI * i / rings, phi = 2.0 * M_PI * j / around;
            directions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
        }
    for (uint32_t i = 0; i < rings; ++i)
        for (uint32_t j = 0; j < around; ++j) {
            const uint32_t a = i * around + j, b = i * around + (j + 1) % around;
            if (i > 0) triangles.emplace_back(a, b, b + around);
            if (i + 1 < rings) triangles.emplace_back(a, b + around, a + around);
        }
    // The poles are one point each: all of the first and the last row are equal.
    for (uint32_t j = 0; j < around; ++j) {
        directions[j] = vec3(0.0f, 1.0f, 0.0f);
        directions[rings * around + j] = vec3(0.0f, -1.0f, 0.0f);
    }
    std::vector<vec3> positions;
    for (const vec3& direction : directions) positions.push_back(centre + radius * direction);
    const uint32_t mesh = addMesh(scene, std::move(positions), std::move(triangles), material);
    if (smooth)
        for (const vec3& direction : directions) scene.meshes[mesh].normals.push_back(glm::normalize(direction));
    return mesh;
}

/// Adds a mesh of one sphere that is one. Returns its index.
inline uint32_t addTrueSphere(Scene& scene, const vec3& centre, float radius, const Material& material) {
    Mesh mesh;
    mesh.spheres = {{centre, radius}};
    mesh.materials = {static_cast<uint32_t>(scene.materials.size())};
    scene.materials.push_back(material);
    scene.meshes.push_back(mesh);
    const auto index = static_cast<uint32_t>(scene.meshes.size() - 1);
    scene.instances.push_back({index, dmat4(1.0)});
    return index;
}

/// A camera at `eye` that looks at `target`, +y up.
inline Camera lookAt(const vec3& eye, const vec3& target, float yfov = 0.785398f) {
    Camera camera;
    camera.eye = eye;
    camera.forward = glm::normalize(target - eye);
    camera.right = glm::normalize(glm::cross(camera.forward, vec3(0.0f, 1.0f, 0.0f)));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.yfov = yfov;
    return camera;
}

/// Where light of radiance 1 comes from everywhere, and a camera that looks at the origin: add what is to be seen in it.
inline Scene whiteSky() {
    Scene scene;
    scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(1.0f), .ground = vec3(1.0f)};
    scene.ambient = vec3(1.0f);
    scene.cameras.push_back(lookAt({0, 0.3f, 4}, {0, 0, 0}));
    return scene;
}

/// A floor with a texture, a wall with vertex colours, a sky, and a camera that looks at what is put between them.
inline Scene variedRoom() {
    Scene scene;
    Material floor = matte(vec3(0.7f, 0.6f, 0.5f));
    floor.baseColorTexture = Texture{0, Wrap::repeat, Wrap::mirror};
    scene.images.push_back({2, 2, {255, 255, 255, 255, 200, 40, 40, 255, 40, 200, 40, 255, 90, 90, 255, 255}});
    const uint32_t quad = addQuad(scene, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, floor);
    scene.meshes[quad].uvs = {{0, 0}, {5, 0}, {5, 5}, {0, 5}};
    const uint32_t wall = addQuad(scene, {-4, 0, -4}, {8, 0, 0}, {0, 5, 0}, matte(vec3(0.8f)));
    scene.meshes[wall].colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    scene.sky = {.zenith = {0.2f, 0.3f, 0.6f}, .horizon = {0.6f, 0.6f, 0.6f}, .ground = {0.1f, 0.1f, 0.1f}};
    scene.ambient = vec3(0.05f);
    scene.cameras.push_back(lookAt({0.5f, 2.0f, 6.0f}, {0.0f, 1.0f, 0.0f}));
    return scene;
}

/// A floor at y = 0 of 2 half on each side, under a camera straight above it, whose one pixel shows the origin.
inline Scene floorFromAbove(const Material& material, float half = 4.0f) {
    Scene scene;
    addQuad(scene, {-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half}, material);
    Camera camera;
    camera.eye = {0.0f, 3.0f, 0.0f};
    camera.forward = {0, -1, 0};
    camera.right = {1, 0, 0};
    camera.up = {0, 0, -1};
    camera.yfov = 1e-4f;
    scene.cameras.push_back(camera);
    return scene;
}

/// A scene with all that rendering it takes.
struct Stage {
    explicit Stage(Scene s, const std::string& accel = "bvh") : scene(std::move(s)), geometry(flatten(scene)) {
        structure = structureType(accel).build(primitivesOf(geometry), {});
        markSeeThrough(scene, geometry, structure);
    }
    /// With its instances kept.
    static Stage kept(Scene s, const std::string& accel = "bvh") {
        Stage stage(Scene{}, accel);
        stage.scene = std::move(s);
        stage.geometry = gatherInstances(stage.scene);
        stage.structure = buildTwoLevels(placedScene(stage.geometry, {}), structureType(accel), {});
        markSeeThrough(stage.scene, stage.geometry, stage.structure);
        return stage;
    }
    Picture onCpu(const FrameOptions& options) const {
        return renderPicture(scene, geometry, *makeCpuTracer(structure), options);
    }

    Scene scene;
    Geometry geometry;
    Structure structure;
};

/// A square picture whose rays are followed down to `maxDepth`, however little they carry unless told.
inline FrameOptions square(uint32_t side, uint32_t samples, uint32_t maxDepth = 8, float minContribution = 0.0f) {
    FrameOptions options;
    options.width = options.height = side;
    options.samples = samples;
    options.maxDepth = maxDepth;
    options.minContribution = minContribution;
    return options;
}

/// Bits of a picture: equal exactly if radiance, discarded weights and ray counts are.
inline std::vector<uint32_t> bitsOf(const Picture& picture) {
    std::vector<uint32_t> bits;
    const auto put = [&](float x) { bits.push_back(std::bit_cast<uint32_t>(x)); };
    for (const vec3& c : picture.radiance) put(c.x), put(c.y), put(c.z);
    for (const float discarded : picture.discarded) put(discarded);
    for (const uint64_t count : {picture.statistics.closestRays, picture.statistics.shadowRays})
        bits.push_back(static_cast<uint32_t>(count));
    return bits;
}

/// Pixels whose radiance or discarded weight differ in any bit.
inline size_t countDifferent(const Picture& a, const Picture& b) {
    size_t different = 0;
    for (size_t i = 0; i < a.radiance.size(); ++i)
        different += a.radiance[i] != b.radiance[i] || a.discarded[i] != b.discarded[i];
    return different;
}

}  // namespace raig::test

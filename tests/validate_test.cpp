// findFault sees each promise of scene.hpp broken, one at a time.
#include "scene/validate.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace raig {
namespace {

Scene soundScene() {
    Scene scene;
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals = {{0, 0, 1}, {0, 0, 0}, {0, 0, 1}};
    mesh.uvs.assign(3, vec2(0.5f));
    mesh.colors.assign(3, vec3(0.5f));
    mesh.triangles = {{0, 1, 2}};
    mesh.materials = {0};
    scene.meshes = {mesh};
    scene.instances = {{0, dmat4(1.0)}};
    scene.materials.resize(1);
    scene.materials[0].baseColorTexture = Texture{};
    scene.images = {{1, 1, {1, 2, 3, 4}}};
    scene.lights.resize(1);
    scene.cameras.resize(2);
    scene.cameras[1].orthographic = true;
    return scene;
}

TEST(FindFault, ASoundSceneHasNone) {
    EXPECT_EQ(findFault(soundScene()), std::nullopt);
    Scene scene = soundScene();
    scene.meshes[0].positions[0].x = std::numeric_limits<float>::quiet_NaN();  // no promise is made
    scene.instances[0].toWorld[0] = dvec4(0.0);                                // singular is allowed
    EXPECT_EQ(findFault(scene), std::nullopt);
}

TEST(FindFault, EachBrokenPromiseIsSeen) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::pair<const char*, std::function<void(Scene&)>> breaks[] = {
        {"there is no material", [](Scene& s) { s.materials.clear(); }},
        {"mesh 0", [](Scene& s) { s.meshes[0].normals.pop_back(); }},
        {"mesh 0", [](Scene& s) { s.meshes[0].uvs.pop_back(); }},
        {"mesh 0", [](Scene& s) { s.meshes[0].colors.pop_back(); }},
        {"mesh 0", [](Scene& s) { s.meshes[0].materials.clear(); }},
        {"mesh 0: triangle 0 names vertex 3 of 3", [](Scene& s) { s.meshes[0].triangles[0].y = 3; }},
        {"mesh 0: primitive 0 names material 1 of 1", [](Scene& s) { s.meshes[0].materials[0] = 1; }},
        {"mesh 0: 1 material indices for 2", [](Scene& s) { s.meshes[0].spheres.push_back({}); }},
        {"mesh 0: primitive 1 names material 3 of 1",
         [](Scene& s) {
             s.meshes[0].spheres.push_back({});
             s.meshes[0].materials.push_back(3);
         }},
        {"instance 0: toWorld makes no spheres of spheres",
         [](Scene& s) {
             s.meshes[0].spheres.push_back({});
             s.meshes[0].materials.push_back(0);
             s.instances[0].toWorld[0].x = 2.0;
         }},
        {"mesh 0: normal 0", [](Scene& s) { s.meshes[0].normals[0].z = 1.1f; }},
        {"mesh 0: normal 0", [=](Scene& s) { s.meshes[0].normals[0].z = nan; }},
        {"mesh 0: uv 1", [=](Scene& s) { s.meshes[0].uvs[1].y = inf; }},
        {"mesh 0: uv 0", [=](Scene& s) { s.meshes[0].uvs[0].x = nan; }},
        {"mesh 0: uv 2", [](Scene& s) { s.meshes[0].uvs[2].x = -2e9f; }},
        {"mesh 0: colour 2", [](Scene& s) { s.meshes[0].colors[2].z = -1; }},
        {"instance 0: names mesh 1", [](Scene& s) { s.instances[0].mesh = 1; }},
        {"instance 0: toWorld is not finite", [=](Scene& s) { s.instances[0].toWorld[2].y = nan; }},
        {"instance 0: toWorld is not affine", [](Scene& s) { s.instances[0].toWorld[3].w = 0; }},
        {"material 0: baseColor", [=](Scene& s) { s.materials[0].baseColor.x = nan; }},
        {"material 0: alpha", [](Scene& s) { s.materials[0].alpha = 1.5f; }},
        {"material 0: emission", [=](Scene& s) { s.materials[0].emission.x = inf; }},
        {"material 0: ior", [](Scene& s) { s.materials[0].ior = 0; }},
        {"mesh 0", [](Scene& s) { s.meshes[0].moreUvs.resize(2); }},
        {"mesh 0: uv 1 of the second", [=](Scene& s) {
             s.meshes[0].moreUvs.assign(3, vec2(0.0f));
             s.meshes[0].moreUvs[1].x = inf;
         }},
        {"mesh 0: tangent 2", [](Scene& s) {
             s.meshes[0].tangents.assign(3, vec4(1, 0, 0, 1));
             s.meshes[0].tangents[2].w = 0.5f;
         }},
        {"material 0: its texture names set", [](Scene& s) { s.materials[0].baseColorTexture->set = 2; }},
        {"material 0: its texture's transform", [=](Scene& s) { s.materials[0].baseColorTexture->u.x = inf; }},
        {"material 0: its texture's transform", [](Scene& s) { s.materials[0].baseColorTexture->v.z = 2e9f; }},
        {"material 0: normalScale", [=](Scene& s) { s.materials[0].normalScale = inf; }},
        {"material 0: normalScale", [](Scene& s) { s.materials[0].normalScale = -2e6f; }},
        {"material 0: occlusionStrength", [](Scene& s) { s.materials[0].occlusionStrength = 2.0f; }},
        {"material 0: its texture", [](Scene& s) { s.materials[0].baseColorTexture->image = 1; }},
        {"image 0", [](Scene& s) { s.images[0].rgba.pop_back(); }},
        {"image 0: is empty", [](Scene& s) { s.images[0] = {}; }},
        {"light 0: direction", [](Scene& s) { s.lights[0].direction = vec3(0.0f); }},
        {"light 0: cone", [](Scene& s) { s.lights[0].innerConeAngle = 2; }},
        {"camera 0: axes are not unit", [](Scene& s) { s.cameras[0].up *= 2.0f; }},
        {"camera 0: axes are not perpendicular", [](Scene& s) { s.cameras[0].up = s.cameras[0].right; }},
        {"camera 0: yfov", [](Scene& s) { s.cameras[0].yfov = 0; }},
        {"camera 1: xmag", [](Scene& s) { s.cameras[1].ymag = -1; }},
        {"sky", [=](Scene& s) { s.sky.zenith.x = nan; }},
        {"ambient", [](Scene& s) { s.ambient.x = -1; }},
    };
    for (const auto& [want, breakIt] : breaks) {
        Scene scene = soundScene();
        breakIt(scene);
        const std::optional<std::string> fault = findFault(scene);
        ASSERT_TRUE(fault) << want;
        EXPECT_TRUE(fault->starts_with(want)) << *fault << ", not " << want;
    }
}

}  // namespace
}  // namespace raig

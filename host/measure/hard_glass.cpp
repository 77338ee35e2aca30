// Cases 54 to 56: glass, cameras where there is no room for them, and rays that end where they begin.
#include "measure/hard_pictures.hpp"
#include "measure/hard_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace raig::hard {

namespace {

/// Light that is 1 everywhere, of which glass loses nothing.
PictureScene furnace(const std::string& name,
                     std::vector<FrameOptions> options = {pictureOf(12, 12, 1), pictureOf(12, 12, 8)}) {
    return {.name = name, .scene = whiteSky(), .options = std::move(options), .fault = furnaceFault};
}

// ---- Case 54 -----------------------------------------------------------------------------------------------------------

/// Balls of all kinds of glass beside each other, as meshes and as spheres: with less, with equal and with more than the
/// index of what is around them, and one in another.
PictureScene balls() {
    PictureScene scene = furnace("balls of glass");
    float x = -5.0f;
    for (const float ior : {1.0f, 1.0000001f, 1.33f, 2.4f, 0.75f, 1.0f / 1.5f}) {
        addBall(scene.scene, vec3(x, 1.1f, 0), 0.9f, 6, glass(ior));
        addSphere(scene.scene, vec3(x, -1.1f, 0), 0.9f, glass(ior));
        x += 2.0f;
    }
    scene.scene.cameras.push_back(cameraAt({0, 0, 12}, {0, 0, -1}, 0.4f));
    scene.options.push_back(pictureOf(24, 8, 16));
    return scene;
}

/// Water in glass, and a bubble of air in water.
PictureScene nested() {
    PictureScene scene = furnace("water and air in glass");
    addSphere(scene.scene, vec3(0), 1.0f, glass(1.5f));
    addSphere(scene.scene, vec3(0), 0.7f, glass(1.33f));
    addBall(scene.scene, vec3(0), 0.3f, 6, glass(1.0f));
    scene.scene.cameras.push_back(cameraAt({0, 0.1f, 4}, {0, 0, -1}, 0.6f));
    return scene;
}

/// A slab seen 1e-4 above its surface.
PictureScene grazing() {
    PictureScene scene = furnace("at 90 degrees less 1e-4", {pictureOf(5, 5, 8)});
    addBox(scene.scene, vec3(-10, -1, -10), vec3(10, 0, 10), glass(1.5f));
    scene.scene.cameras.push_back(cameraAt({-1, 1e-4f, 0}, {1, -1e-4f, 0}, 1e-4f));
    return scene;
}

/// Behind a slab the world looks as without it: what is bent by mu on the one side is bent back by 1 / mu on the other, and
/// light that is thrown to and fro between them comes from the same height. The sky's radiance is that height.
PictureScene slab(float ior) {
    PictureScene scene;
    scene.name = fmt::format("in by {:g}, out by its inverse", ior);
    scene.scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(0.0f), .ground = vec3(1.0f)};
    addQuad(scene.scene, {-400, -400, 0}, {800, 0, 0}, {0, 800, 0}, glass(ior));
    addQuad(scene.scene, {-400, -400, -1}, {0, 800, 0}, {800, 0, 0}, glass(ior));
    scene.scene.cameras.push_back(cameraAt({0, 0, 2}, {0, 0.5f, -1}, 0.6f));
    scene.options.push_back(pictureOf(9, 9, 12));
    scene.fault = [rayOf = pixelRays(scene.scene)](const Picture& picture, const FrameOptions& options,
                                                   size_t pixel) -> std::string {
        const double height = std::abs(double{rayOf(options, pixel).direction.y});
        const double seen = picture.radiance[pixel].x, want = height * (1.0 - picture.discarded[pixel]);
        if (std::abs(seen - want) <= roundingOf(options.maxDepth)) return "";
        return fmt::format("{:.9g} instead of {:.9g}", seen, want);
    };
    return scene;
}

std::vector<PictureScene> dielectrics(const Draw&) {
    std::vector<PictureScene> scenes = {balls(), nested(), grazing(), slab(1.5f), slab(0.9f)};
    std::ranges::move(mediaInMedia(), std::back_inserter(scenes));
    return scenes;
}

// ---- Case 55 -----------------------------------------------------------------------------------------------------------

std::string radianceFault(const Picture& picture, size_t pixel, float want) {
    const float seen = picture.radiance[pixel].x;
    return seen == want ? "" : fmt::format("{:.9g} instead of {:.9g}", seen, want);
}

PictureScene withinGlass(bool isMesh) {
    PictureScene scene = furnace(isMesh ? "within a ball of glass" : "within a sphere of glass", {pictureOf(9, 9, 12)});
    if (isMesh)
        addBall(scene.scene, vec3(0), 1.0f, 8, glass(1.5f));
    else
        addSphere(scene.scene, vec3(0), 1.0f, glass(1.5f));
    scene.scene.cameras.push_back(cameraAt({0.3f, 0.5f, 0.1f}, {-0.2f, 0.3f, -1}, 2.0f));
    return scene;
}

/// What glows fills the picture: from within, and from where the camera lies on it, to either side.
PictureScene atGlow(const std::string& name, const vec3& eye, const vec3& forward, bool isSphere) {
    PictureScene scene{.name = name, .options = {pictureOf(8, 8, 4)}};
    if (isSphere)
        addSphere(scene.scene, vec3(0), 2.0f, glowing(0.75f));
    else
        addQuad(scene.scene, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0}, glowing(0.75f));
    scene.scene.cameras.push_back(cameraAt(eye, forward, 1.0f));
    scene.fault = [](const Picture& picture, const FrameOptions&, size_t pixel) {
        return radianceFault(picture, pixel, 0.75f);
    };
    return scene;
}

/// In a triangle's plane it is not seen.
PictureScene inPlane() {
    PictureScene scene = atGlow("in the plane of what glows", {0.5f, 0.25f, 0}, {1, 0, 0}, false);
    scene.scene.cameras[0].orthographic = true;
    scene.scene.cameras[0].up = {0, 1, 0};
    scene.scene.cameras[0].right = {0, 0, 1};
    scene.scene.cameras[0].xmag = 1e-30f;
    scene.options = {pictureOf(1, 5, 4)};
    scene.fault = [](const Picture& picture, const FrameOptions&, size_t pixel) {
        return radianceFault(picture, pixel, 0.0f);
    };
    return scene;
}

std::vector<PictureScene> cameras(const Draw&) {
    std::vector<PictureScene> scenes = {
        withinGlass(true),
        withinGlass(false),
        atGlow("within what glows", {0.5f, 0.25f, 0.125f}, {0.2f, 0.3f, -1}, true),
        atGlow("on a wall that glows, towards it", {0.5f, 0.25f, 0}, {0, 0, -1}, false),
        atGlow("on a wall that glows, away from it", {0.5f, 0.25f, 0}, {0, 0.1f, 1}, false),
        atGlow("on a sphere that glows", {0, 0, 2}, {0, 0, -1}, true),
        inPlane()};
    std::ranges::move(eyesInMedia(), std::back_inserter(scenes));
    return scenes;
}

// ---- Case 56 -----------------------------------------------------------------------------------------------------------

/// A sphere that absorbs and does not bend: each pixel tells how long its ray was inside. A ray that found itself at once
/// where it went in, or that could not come out of the sphere it went into, would be seen.
PictureScene absorbing(float offset) {
    PictureScene scene;
    scene.name = fmt::format("through what absorbs, {:g} off the origin", offset);
    scene.scene = whiteSky();
    Material m = glass(1.0f);
    m.attenuationColor = vec3(0.5f);
    m.attenuationDistance = 1.0f;
    addSphere(scene.scene, vec3(offset), 1.0f, m);
    Camera camera = cameraAt(vec3(offset) + vec3(0, 0, 3), {0, 0, -1}, 1.0f);
    camera.orthographic = true;
    camera.xmag = camera.ymag = 1.02f;
    scene.scene.cameras.push_back(camera);
    scene.options.push_back(pictureOf(33, 33, 4));
    scene.fault = [rayOf = pixelRays(scene.scene), offset](const Picture& picture, const FrameOptions& options,
                                                           size_t pixel) -> std::string {
        const dvec3 from = dvec3(rayOf(options, pixel).origin) - dvec3(double{offset});
        const double height = std::hypot(from.x, from.y), slack = 64.0 * 0x1p-24 * (4.0 + std::abs(offset));
        const auto left = [&](double h) { return h >= 1.0 ? 1.0 : std::pow(0.5, 2.0 * std::sqrt(1.0 - h * h)); };
        const double least = left(std::max(0.0, height - slack)) - 2.0 * slack, most = left(height + slack) + 2.0 * slack;
        const double seen = picture.radiance[pixel].x;
        if (seen >= least && seen <= most) return "";
        return fmt::format("{:.9g} instead of {:.9g} to {:.9g}", seen, least, most);
    };
    return scene;
}

/// From within glass at its wall, about the angle at which light leaves along it.
PictureScene critical(float yfov) {
    PictureScene scene = furnace(fmt::format("out along the interface, within {:g}", yfov), {pictureOf(7, 7, 12)});
    addBox(scene.scene, vec3(-4, -4, -4), vec3(4, 4, 0), glass(1.5f));
    scene.scene.cameras.push_back(
        cameraAt({0.25f, -1.0f, -1.5f}, vec3(0.0f, 2.0f / 3.0f, float(std::sqrt(5.0) / 3.0)), yfov));
    return scene;
}

std::vector<PictureScene> interfaces(const Draw&) {
    return {absorbing(0.0f), absorbing(100.0f), critical(1e-2f), critical(1e-6f)};
}

}  // namespace

std::vector<PictureCase> glassCases() {
    return {{54, "glass in glass, at the critical angle and beyond", dielectrics},
            {55, "cameras within things, and on them", cameras},
            {56, "rays along surfaces, and out of what they went into", interfaces}};
}

}  // namespace raig::hard

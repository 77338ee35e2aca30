// Cases 58 to 61: pictures of all sizes, arrays beyond a limit, tiles of one pixel, and numbers that are none.
#include "measure/hard_pictures.hpp"
#include "measure/hard_scenes.hpp"
#include "measure/oracle.hpp"
#include "rays/lights.hpp"
#include "rays/primitives.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace raig::hard {

namespace {

/// A sky whose radiance is the height of the direction, and two triangles that glow.
PictureScene skyAndGlow() {
    PictureScene scene;
    scene.scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(0.0f), .ground = vec3(0.5f)};
    addQuad(scene.scene, {-0.5f, -0.25f, -3}, {1.5f, 0.125f, 0}, {0.25f, 1, 0}, glowing(2.0f));
    scene.scene.cameras.push_back(cameraAt({0, 0, 0}, {0.1f, 0.2f, -1}, 0.9f));
    const auto oracle = std::make_shared<Oracle>(primitivesOf(flatten(scene.scene)));
    scene.fault = [rayOf = pixelRays(scene.scene), oracle](const Picture& picture, const FrameOptions& options,
                                                           size_t pixel) -> std::string {
        const Ray ray = rayOf(options, pixel);
        const double height = ray.direction.y, sky = height >= 0.0 ? height : -0.5 * height;
        const double want = oracle->closest(ray).primitive != NO_HIT ? 2.0 : sky, seen = picture.radiance[pixel].x;
        if (std::abs(seen - want) <= 4.0 * 0x1p-24 || (oracle->isOpen(ray) && std::abs(seen - sky) <= 4.0 * 0x1p-24) ||
            (oracle->isOpen(ray) && seen == 2.0))
            return "";
        return fmt::format("{:.9g} instead of {:.9g}", seen, want);
    };
    return scene;
}

/// Case 58.
std::vector<PictureScene> sizes(const Draw&) {
    PictureScene scene = skyAndGlow();
    scene.name = "1 x 1 to 65536 x 1";
    for (const uvec2 size : {uvec2(1, 1), uvec2(1, 19), uvec2(19, 1), uvec2(13, 11), uvec2(8, 9), uvec2(9, 8),
                             uvec2(65536, 1), uvec2(1, 65536)})
        scene.options.push_back(pictureOf(size.x, size.y, 2));
    return {scene};
}

/// Something of everything: mirrors, glass, a texture, a lamp and a light.
raig::Scene varied() {
    raig::Scene scene;
    scene.sky = {.zenith = {0.2f, 0.3f, 0.6f}, .horizon = {0.6f, 0.6f, 0.6f}, .ground = {0.1f, 0.1f, 0.1f}};
    Material floor;
    floor.baseColorTexture = Texture{0, Wrap::repeat, Wrap::mirror};
    scene.images.push_back({2, 2, {255, 255, 255, 255, 200, 40, 40, 255, 40, 200, 40, 255, 90, 90, 255, 255}});
    addQuad(scene, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, floor);
    scene.meshes.back().uvs = {{0, 0}, {5, 0}, {5, 5}, {0, 5}};
    addQuad(scene, {-1, 3.5f, 0}, {2, 0, 0}, {0, 0, 1}, glowing(4.0f));
    addBall(scene, {-1, 1, 0}, 0.9f, 10, mirror(0.9f));
    addSphere(scene, {1, 1, 0.5f}, 0.9f, glass(1.5f));
    scene.lights = {{.type = Light::Type::point, .position = {3, 4, 2}, .intensity = vec3(9.0f)}};
    scene.cameras.push_back(cameraAt({0.5f, 2.0f, 6.0f}, {-0.05f, -0.17f, -1}, 0.7f));
    return scene;
}

std::string nothing(const Picture&, const FrameOptions&, size_t) {
    return "";
}

/// By brute force on the CPU.
Picture pictureOfCpu(const raig::Scene& scene, const FrameOptions& options) {
    const Geometry geometry = flatten(scene);
    Structure structure = structureType("brute").build(primitivesOf(geometry), {});
    markSeeThrough(scene, geometry, structure);
    return renderPicture(scene, geometry, *makeCpuTracer(structure), options);
}

/// The pixel must be that of the other picture, to rounding: it may be of another device.
std::string otherFault(const Picture& picture, const Picture& other, size_t pixel) {
    const vec3 seen = picture.radiance[pixel], want = other.radiance[pixel];
    for (int channel = 0; channel < 3; ++channel)
        if (!(std::abs(double{seen[channel]} - double{want[channel]}) <= 1e-4 * (1.0 + double{want[channel]})))
            return fmt::format("{:.9g} instead of {:.9g}", seen[channel], want[channel]);
    return "";
}

/// Case 59: arrays that do not fit one binding are split, to the same bits; or else refused.
std::vector<PictureScene> limits(const Draw&) {
    const FrameOptions options = pictureOf(16, 12, 4);
    const auto want = std::make_shared<Picture>(pictureOfCpu(varied(), options));
    PictureScene split{.name = "arrays of at most 1024 elements", .scene = varied(), .options = {options}};
    split.fault = [want](const Picture& picture, const FrameOptions&, size_t pixel) {
        return otherFault(picture, *want, pixel);
    };
    split.largestBinding = 1024;
    PictureScene refused{.name = "arrays of at most 16 elements", .scene = varied(), .options = {options}, .fault = nothing};
    refused.largestBinding = 16;
    refused.isRefused = true;
    return {split, refused};
}

/// Case 60.
std::vector<PictureScene> tiles(const Draw&) {
    std::vector<PictureScene> scenes;
    for (const Integrator integrator : {Integrator::whitted, Integrator::path, Integrator::ao}) {
        PictureScene scene{.name = fmt::format("tiles of 1 to 64 pixels, {}", integratorNames[size_t(integrator)]),
                           .scene = varied(),
                           .fault = nothing,
                           .sameBits = true};
        for (const uint32_t tile : {0u, 1u, 7u, 64u}) {
            scene.options.push_back(pictureOf(9, 5, 3));
            scene.options.back().tilePixels = tile;
            scene.options.back().integrator = integrator;
        }
        scenes.push_back(scene);
    }
    return scenes;
}

/// Case 61: among others, triangles and spheres that are none; the picture is that of the others.
std::vector<PictureScene> noNumbers(const Draw&) {
    const FrameOptions options = pictureOf(16, 12, 4);
    PictureScene scene{.name = "corners and radii that are no numbers", .scene = varied(), .options = {options}};
    const auto want = std::make_shared<Picture>(pictureOfCpu(scene.scene, options));
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {nan, inf, -inf, 1e30f, 3.4e38f}) {
        addMesh(scene.scene, {vec3(0, 1, 2), vec3(1, bad, 2), vec3(1, 2, 2)}, {{0, 1, 2}}, mirror(0.9f));
        addMesh(scene.scene, {vec3(bad), vec3(bad), vec3(bad)}, {{0, 1, 2}}, glass(1.5f));
        addSphere(scene.scene, vec3(0, 1, 2), bad, glass(1.5f));
        addSphere(scene.scene, vec3(bad, 1, 2), 0.5f, mirror(0.9f));
    }
    scene.fault = [want](const Picture& picture, const FrameOptions&, size_t pixel) {
        return otherFault(picture, *want, pixel);
    };
    return {scene};
}

}  // namespace

std::vector<PictureCase> frameCases() {
    return {{58, "pictures of all sizes", sizes},
            {59, "arrays beyond a device's limit", limits},
            {60, "tiles of one pixel", tiles},
            {61, "numbers that are none", noNumbers}};
}

std::vector<PictureCase> pictureCases() {
    std::vector<PictureCase> all;
    for (const auto& cases : {recursionCases(), glassCases(), itemCases(), frameCases()})
        all.insert(all.end(), cases.begin(), cases.end());
    return all;
}

}  // namespace raig::hard

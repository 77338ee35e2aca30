// Cases 52 and 53: how deep light is followed, and what is said of the rest.
#include "measure/hard_pictures.hpp"
#include "measure/hard_scenes.hpp"

#include <fmt/format.h>

#include <cmath>

namespace raig::hard {

namespace {

constexpr double glow = 0.25;

/// Of light that is `glow` at each of N + 1 places, each time reflected by K: what is not explained by what is cut off.
auto seriesFault(float reflectance) {
    return [reflectance](const Picture& picture, const FrameOptions& options, size_t pixel) -> std::string {
        const double rest = std::pow(double{reflectance}, options.maxDepth + 1.0), whole = glow / (1.0 - reflectance);
        const double seen = picture.radiance[pixel].x, discarded = picture.discarded[pixel];
        const double slack = roundingOf(options.maxDepth);
        if (std::abs(discarded - rest) > slack)
            return fmt::format("depth {}: discarded weight {:.9g} instead of {:.9g}", options.maxDepth, discarded, rest);
        if (std::abs(seen - whole * (1.0 - rest)) > slack * whole || whole - seen > (discarded + slack) * whole)
            return fmt::format("depth {}: {:.9g} instead of {:.9g}, of which {:.9g} is discarded", options.maxDepth, seen,
                               whole, discarded);
        return "";
    };
}

/// The same picture by Whitted's integrator and by paths, which have no choice in it.
void addBoth(FrameOptions options, PictureScene& scene) {
    scene.options.push_back(options);
    options.integrator = Integrator::path;
    scene.options.push_back(options);
}

/// Case 52: between two mirrors that glow, light adds up to a geometric series: glow / (1 - K). Cut off after N + 1 terms,
/// K^(N+1) of it is left out.
PictureScene facingMirrors(float reflectance) {
    PictureScene scene;
    scene.name = fmt::format("K {:g}", reflectance);
    Material m = mirror(reflectance);
    m.emission = vec3(float(glow));
    addQuad(scene.scene, {-10, -10, -1}, {20, 0, 0}, {0, 20, 0}, m);
    addQuad(scene.scene, {-10, -10, 1}, {0, 20, 0}, {20, 0, 0}, m);
    scene.scene.cameras.push_back(cameraAt({0.1f, 0.2f, 0}, {0, 0, -1}, 0.001f));
    for (const uint32_t depth : {3u, 8u, 15u, 30u}) addBoth(pictureOf(2, 2, depth), scene);
    scene.fault = seriesFault(reflectance);
    return scene;
}

/// The same within a sphere that glows and scatters K: only paths follow that. A ray that got out of it would miss its rest.
PictureScene closedSphere(float reflectance, float radius, float offset) {
    PictureScene scene;
    scene.name = fmt::format("paths in a sphere of radius {:g}, {:g} off the origin, K {:g}", radius, offset, reflectance);
    Material m;
    m.baseColor = vec3(reflectance);
    m.emission = vec3(float(glow));
    addSphere(scene.scene, vec3(offset), radius, m);
    scene.scene.cameras.push_back(cameraAt(vec3(offset) + radius * vec3(0.3f, 0.2f, 0.1f), {0.1f, 0.5f, -1}, 1.5f));
    for (const uint32_t depth : {3u, 15u, 60u}) {
        scene.options.push_back(pictureOf(4, 4, depth));
        scene.options.back().integrator = Integrator::path;
    }
    scene.fault = seriesFault(reflectance);
    return scene;
}

std::vector<PictureScene> mirrors(const Draw&) {
    return {facingMirrors(0.5f),           facingMirrors(0.9f),
            facingMirrors(0.98f),          closedSphere(0.75f, 1.0f, 0.0f),
            closedSphere(0.9f, 1e-6f, 0.0f), closedSphere(0.9f, 1e6f, 0.0f),
            closedSphere(0.9f, 1.0f, 100.0f)};
}

/// Case 53: panes that reflect half of the light and let the other half pass, `count` on each side of the camera. Of light
/// that is 1 everywhere nothing is lost. Each level has twice the rays of the one before; a path has one.
PictureScene panes(int count, uint32_t depth, const std::vector<float>& contributions) {
    PictureScene scene{.name = fmt::format("{} panes on each side", count), .scene = whiteSky(), .fault = furnaceFault};
    Material pane = glass(5.8284273f);  // ((n - 1) / (n + 1))^2 = 1/2
    pane.thin = true;
    for (int i = 0; i < count; ++i)
        for (const float z : {float(2 * i + 1), float(-2 * i - 1)})
            addQuad(scene.scene, {-20, -20, z}, {40, 0, 0}, {0, 40, 0}, pane);
    scene.scene.cameras.push_back(cameraAt({0.1f, 0.2f, 0}, {0, 0, -1}, 0.001f));
    for (const float least : contributions) addBoth(pictureOf(2, 2, depth, least), scene);
    return scene;
}

std::vector<PictureScene> branches(const Draw&) {
    return {panes(1, 12, {0.0f, 1.0f / 1024.0f, 0.1f, 0.7f}), panes(3, 6, {0.0f, 1.0f / 33.0f, 1.0f / 31.0f}),
            panes(12, 8, {1.0f / 255.0f})};
}

}  // namespace

double roundingOf(uint32_t depth) {
    return 32.0 * 0x1p-24 * (depth + 2.0);
}

std::string furnaceFault(const Picture& picture, const FrameOptions& options, size_t pixel) {
    const vec3 seen = picture.radiance[pixel];
    const double discarded = picture.discarded[pixel], slack = roundingOf(options.maxDepth);
    for (int channel = 0; channel < 3; ++channel)
        if (!(std::abs(seen[channel] + discarded - 1.0) <= slack))
            return fmt::format("NIVELL_MAX {}, MIN_CONTRIB {:g}: {:.9g} and a discarded weight of {:.9g} do not make 1",
                               options.maxDepth, options.minContribution, seen[channel], discarded);
    return "";
}

std::vector<PictureCase> recursionCases() {
    return {{52, "two facing mirrors", mirrors}, {53, "panes that divide light in two", branches}};
}

}  // namespace raig::hard

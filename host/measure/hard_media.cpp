// Of cases 54 and 55: things of glass within each other, looked through straight, so that each pixel has a closed form.
#include "measure/hard_pictures.hpp"
#include "measure/hard_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace raig::hard {

namespace {

/// What fills z from `hi` down to `lo`, but for what comes after it in a list.
struct Slab {
    float hi;
    float lo;
    float ior;
    float kept = 1.0f;  ///< what is left of light after a unit of length
};

/// Between two surfaces all is the same.
struct Layer {
    double hi;
    double lo;
    double ior = 1.0;
    double kept = 1.0;
};

std::vector<Layer> layersOf(const std::vector<Slab>& slabs, double from, double to) {
    std::vector<double> cuts = {from, to};
    for (const Slab& slab : slabs)
        for (const double cut : {double{slab.hi}, double{slab.lo}})
            if (cut < from && cut > to) cuts.push_back(cut);
    std::ranges::sort(cuts, std::greater{});
    std::vector<Layer> layers;
    for (size_t i = 0; i + 1 < cuts.size(); ++i) {
        Layer layer{cuts[i], cuts[i + 1]};
        const double middle = 0.5 * (layer.hi + layer.lo);
        for (const Slab& slab : slabs)
            if (middle < slab.hi && middle > slab.lo) layer = {layer.hi, layer.lo, slab.ior, slab.kept};
        layers.push_back(layer);
    }
    return layers;
}

/// The radiance that comes up at `eye` (on a surface: above it), if what glows with radiance 1 is below all layers and
/// nothing comes from above. Light that goes to and fro between surfaces is followed until no more comes of it. Source:
/// Fresnel's equations, upright.
double radianceAt(double eye, const std::vector<Layer>& layers) {
    const auto reflected = [&](size_t a, size_t b) {
        const double r = (layers[a].ior - layers[b].ior) / (layers[a].ior + layers[b].ior);
        return r * r;
    };
    const auto through = [&](size_t i, double length) { return std::pow(layers[i].kept, length); };
    const size_t n = layers.size(), last = n - 1;
    // Of a ray that runs all through layer i: down, and up.
    std::vector<std::array<double, 2>> seen(n, {0.0, 0.0});
    const auto beyond = [&](size_t i, int way) {
        if (way == 0 && i == last) return 1.0;
        if (way == 1 && i == 0) return 0.0;
        const size_t next = way == 0 ? i + 1 : i - 1;
        const double r = reflected(i, next);
        return r * seen[i][1 - way] + (1.0 - r) * seen[next][way];
    };
    for (int round = 0; round < 2000; ++round)
        for (size_t i = 0; i < n; ++i)
            for (const int way : {0, 1}) seen[i][way] = through(i, layers[i].hi - layers[i].lo) * beyond(i, way);
    for (size_t i = 0; i < n; ++i)
        if (eye < layers[i].hi && eye >= layers[i].lo) return through(i, eye - layers[i].lo) * beyond(i, 0);
    return 0.0;
}

/// A look straight down through slabs at what glows at `floor`.
PictureScene slabs(const std::string& name, const std::vector<Slab>& some, float eye, float floor) {
    PictureScene scene{.name = name};
    float half = 20.0f;  // each is smaller than those before it, as the sides of things within others are
    for (const Slab& slab : some) {
        Material m = glass(slab.ior);
        if (slab.kept < 1.0f) {
            m.attenuationColor = vec3(slab.kept);
            m.attenuationDistance = 1.0f;
        }
        addBox(scene.scene, {-half, -half, slab.lo}, {half, half, slab.hi}, m);
        half -= 1.0f;
    }
    addQuad(scene.scene, {-half, -half, floor}, {2 * half, 0, 0}, {0, 2 * half, 0}, glowing(1.0f));
    Camera camera = cameraAt({0.1f, 0.2f, eye}, {0, 0, -1}, 1.0f);
    camera.orthographic = true;
    camera.xmag = camera.ymag = 1.0f;
    scene.scene.cameras.push_back(camera);
    for (const uint32_t depth : {4u, 16u, 64u}) scene.options.push_back(pictureOf(3, 3, depth, 1e-4f));
    const double want = radianceAt(eye, layersOf(some, 100.0, floor));
    scene.fault = [want](const Picture& picture, const FrameOptions& options, size_t pixel) -> std::string {
        const double seen = picture.radiance[pixel].x, discarded = picture.discarded[pixel];
        const double slack = roundingOf(std::min(options.maxDepth, 16u));
        const bool isBounded = seen <= want + slack && want - seen <= discarded + slack;
        if (isBounded && (options.maxDepth < 16 || discarded < 0.01)) return "";
        return fmt::format("depth {}: {:.9g} instead of {:.9g}, with a discarded weight of {:.3g}", options.maxDepth, seen,
                           want, discarded);
    };
    return scene;
}

const Slab glassSlab{0, -4, 1.5f}, waterSlab{-1, -3, 1.33f}, bubble{-1.5f, -2.5f, 1.0f};

}  // namespace

std::vector<PictureScene> mediaInMedia() {
    const Slab amber{0, -4, 1.5f, 0.5f}, wine{-1, -3, 1.33f, 0.25f};
    return {slabs("water in glass, straight through", {glassSlab, waterSlab}, 2, -6),
            slabs("air in water in glass, straight through", {glassSlab, waterSlab, bubble}, 2, -6),
            slabs("what absorbs in what absorbs", {amber, wine, bubble}, 2, -6),
            slabs("a floor in wine in glass", {amber, wine}, 2, -2),
            slabs("diamond in what is less than air", {{0, -4, 0.75f}, {-1, -3, 2.4f}}, 2, -6),
            slabs("glass in glass of the same index", {glassSlab, {-1, -3, 1.5f}}, 2, -6),
            slabs("water that reaches into its glass", {{0, -1.2f, 1.5f}, {-1, -3, 1.33f}, {-2.8f, -4, 1.5f}}, 2, -6)};
}

std::vector<PictureScene> eyesInMedia() {
    const std::vector<Slab> all = {{0, -4, 1.5f, 0.5f}, {-1, -3, 1.33f, 0.25f}, {-1.5f, -2.5f, 1.0f}};
    return {slabs("an eye in glass, over water", all, -0.5f, -6), slabs("an eye in water, over air", all, -1.25f, -6),
            slabs("an eye in a bubble", all, -2, -6), slabs("an eye in glass, under water", all, -3.5f, -6),
            slabs("an eye in water, on a bubble", all, -1.5f, -6)};
}

}  // namespace raig::hard

/// Pictures by paths whose means are known.
#pragma once

#include "support/ways.hpp"

#include <gtest/gtest.h>

namespace raig::test {

/// Options of a square picture by paths.
inline FrameOptions paths(uint32_t side, uint32_t samples, uint32_t maxDepth = 8, float minContribution = 0.0f) {
    FrameOptions options = square(side, samples, maxDepth, minContribution);
    options.integrator = Integrator::path;
    return options;
}

/// The green of each pixel.
inline std::vector<double> greens(const std::vector<dvec3>& pixels) {
    std::vector<double> values;
    for (const dvec3& pixel : pixels) values.push_back(pixel.y);
    return values;
}

/// On the CPU and by the reference.
class Paths : public ByEveryWay {
protected:
    std::vector<dvec3> render(const Scene& scene, const FrameOptions& options) const {
        return WayOfScene(GetParam(), scene).render(options);
    }
    /// The mean of a picture for each of so many seeds: these are independent of each other, the pixels need not be.
    Sample meansOf(const Scene& scene, FrameOptions options, uint32_t seeds = 32) const {
        WayOfScene way(GetParam(), scene);
        std::vector<double> means;
        for (options.seed = 0; options.seed < seeds; ++options.seed)
            means.push_back(sampleOf(greens(way.render(options))).mean);
        return sampleOf(means);
    }
};

/// The share of its light that a unit square sends to one that shares a side with it, at a right angle [Howell 2010, "A
/// Catalog of Radiation Heat Transfer Configuration Factors", C-14].
constexpr double formFactor = 0.200044;

/// A grey floor beside a lamp that stands on it, which is black otherwise: all light is direct.
inline Scene lampOnFloor(float reflectance, float radiance) {
    Scene scene;
    addQuad(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, matte(vec3(reflectance)));
    addQuad(scene, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, glowing(vec3(radiance)));
    Camera camera;
    camera.orthographic = true;
    camera.eye = {0.5f, 0.5f, 2};
    camera.forward = {0, 0, -1};
    camera.up = {0, 1, 0};
    camera.right = {1, 0, 0};
    camera.xmag = camera.ymag = 0.499f;
    scene.cameras.push_back(camera);
    return scene;
}

}  // namespace raig::test

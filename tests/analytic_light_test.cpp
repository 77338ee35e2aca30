// Light that goes from square to square, against closed forms: by t-tests at fixed seeds, by every way of rendering.
#include "support/ways.hpp"

#include <cmath>

namespace raig {
namespace {

using namespace test;

/// A camera whose picture is the square of side 2 `half` around `centre`, seen from `distance` along `forward`.
Camera facing(const vec3& centre, const vec3& forward, const vec3& up, float half, float distance) {
    Camera camera;
    camera.orthographic = true;
    camera.forward = forward;
    camera.up = up;
    camera.right = glm::cross(forward, up);
    camera.eye = centre - distance * forward;
    camera.xmag = camera.ymag = half;
    return camera;
}

/// What two opposed unit squares at distance `d` send each other, as a share of all that one sends.
/// Source: Howell 2010, "A Catalog of Radiation Heat Transfer Configuration Factors", C-11.
double parallelFactor(double d) {
    const double x = 1.0 / d, xx = x * x;
    return 2.0 / (M_PI * xx) *
           (0.5 * std::log((1 + xx) * (1 + xx) / (1 + 2 * xx)) +
            2.0 * x * std::sqrt(1 + xx) * std::atan(x / std::sqrt(1 + xx)) - 2.0 * x * std::atan(x));
}

/// What a unit square sends to a rectangle of height `h` that stands on one of its sides, at a right angle.
/// Source: ibid., C-14.
double perpendicularFactor(double h) {
    const double w = 1.0, hh = h * h, ww = w * w, s = hh + ww;
    const double logarithm = std::log((1 + ww) * (1 + hh) / (1 + s)) + ww * std::log(ww * (1 + s) / ((1 + ww) * s)) +
                             hh * std::log(hh * (1 + s) / ((1 + hh) * s));
    return (w * std::atan(1 / w) + h * std::atan(1 / h) - std::sqrt(s) * std::atan(1 / std::sqrt(s)) + 0.25 * logarithm) /
           (M_PI * w);
}

TEST(FormFactors, AreThoseOfTheTables) {
    EXPECT_NEAR(parallelFactor(1.0), 0.199825, 5e-7);
    EXPECT_NEAR(perpendicularFactor(1.0), 0.200044, 5e-7);
}

constexpr float radiance = 3.0f, reflectance = 0.5f;

/// The mean of a picture, for each of 32 seeds: the seeds are independent of each other, the pixels need not be.
Sample meansOf(const std::string& way, const Scene& scene) {
    WayOfScene rendered(way, scene);
    std::vector<double> means;
    for (uint32_t seed = 0; seed < 32; ++seed) {
        FrameOptions options = square(12, 32, 0);
        options.seed = seed;
        double sum = 0.0;
        const std::vector<dvec3> pixels = rendered.render(options);
        for (const dvec3& pixel : pixels) sum += pixel.y;
        means.push_back(sum / double(pixels.size()));
    }
    return sampleOf(means);
}

class SquareToSquare : public ByEveryWay {};

// A square that is lit by another looks, in the mean, its reflectance times the form factor times the other's radiance.
TEST_P(SquareToSquare, OpposedSquaresLightEachOtherByTheirFormFactor) {
    for (const float distance : {1.0f, 0.5f}) {
        Scene scene;
        addQuad(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, matte(vec3(reflectance)));
        addQuad(scene, {0, 0, distance}, {0, 1, 0}, {1, 0, 0}, glowing(vec3(radiance)));
        scene.cameras.push_back(facing({0.5f, 0.5f, 0}, {0, 0, -1}, {0, 1, 0}, 0.5f, 0.25f));
        expectMean(meansOf(GetParam(), scene), reflectance * parallelFactor(distance) * radiance, 0.01);
    }
}

// The upright one begins above the other: at a shared side the estimate's variance would have no bound.
TEST_P(SquareToSquare, UprightSquaresLightTheFloorByTheirFormFactor) {
    const double low = 0.25, high = 1.25;
    Scene scene;
    addQuad(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, matte(vec3(reflectance)));
    addQuad(scene, {0, 0, float(low)}, {0, 1, 0}, {0, 0, float(high - low)}, glowing(vec3(radiance)));
    scene.cameras.push_back(facing({0.5f, 0.5f, 0}, {0, 0, -1}, {0, 1, 0}, 0.5f, 4.0f));
    const double factor = perpendicularFactor(high) - perpendicularFactor(low);
    expectMean(meansOf(GetParam(), scene), reflectance * factor * radiance, 0.01);
}

/// The irradiance at `p`, normal `n`, of a polygon of radiance 1 that is wholly above it.
/// Source: Lambert 1760, "Photometria": the sum over the edges of their angles, along n.
double irradianceOf(const std::vector<dvec3>& corners, const dvec3& p, const dvec3& n) {
    double sum = 0.0;
    for (size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = glm::normalize(corners[i] - p), b = glm::normalize(corners[(i + 1) % corners.size()] - p);
        const dvec3 across = glm::cross(a, b);
        sum += std::atan2(glm::length(across), glm::dot(a, b)) * glm::dot(glm::normalize(across), n);
    }
    return std::abs(sum) / 2.0;
}

TEST_P(SquareToSquare, APointIsLitAsTheContourIntegralSays) {
    const vec3 corner(-0.3f, 0.9f, -0.4f), u(1.0f, 0.25f, 0.125f), v(-0.25f, 0.5f, 0.75f);  // tilted every way
    const std::vector<dvec3> corners = {corner, corner + u, corner + u + v, corner + v};
    Scene scene;
    addQuad(scene, {-9, 0, 9}, {18, 0, 0}, {0, 0, -18}, matte(vec3(reflectance)));
    addQuad(scene, corner, u, v, glowing(vec3(radiance)));
    const std::vector<dvec3> points = {{0, 0, 0}, {-0.5, 0, 0.25}, {1.5, 0, -1}, {-2, 0, 3}};
    for (const dvec3& p : points) scene.cameras.push_back(facing(vec3(p), {0, -1, 0}, {0, 0, -1}, 1e-5f, 0.25f));
    WayOfScene rendered(GetParam(), scene);
    for (uint32_t camera = 0; camera < points.size(); ++camera) {
        SCOPED_TRACE(camera);
        FrameOptions options = square(24, 4, 0);
        options.camera = camera;
        std::vector<double> values;  // pixels are independent of each other, and all of the same point
        for (const dvec3& pixel : rendered.render(options)) values.push_back(pixel.y);
        const double irradiance = radiance * irradianceOf(corners, points[camera], {0, 1, 0});
        expectMean(sampleOf(values), reflectance / M_PI * irradiance, 0.04);
    }
}

INSTANTIATE_TEST_SUITE_P(, SquareToSquare, testing::ValuesIn(waysToTest()), testName);

}  // namespace
}  // namespace raig

// Mirrors and glass against closed forms, by every way of rendering: Fresnel, Snell, Beer and Lambert, and a lens.
#include "support/ways.hpp"

#include <cmath>

namespace raig {
namespace {

using namespace test;

class Optics : public ByEveryWay {};

/// A camera that sees one ray: from `distance` before `point`, along `forward` (in the plane z = 0, not along z).
Camera ray(const vec3& point, const vec3& forward, float distance) {
    Camera camera;
    camera.orthographic = true;
    camera.forward = forward;
    camera.right = {0, 0, 1};
    camera.up = glm::cross(camera.right, forward);
    camera.eye = point - distance * forward;
    camera.xmag = camera.ymag = 1e-6f;
    return camera;
}

vec3 downAt(double degrees) {
    const double angle = degrees * M_PI / 180.0;
    return {float(std::sin(angle)), float(-std::cos(angle)), 0.0f};
}

/// Level, large, and seen from above if `up`.
void addLevel(Scene& scene, float y, bool up, const Material& material, float half = 4e4f) {
    if (up)
        addQuad(scene, {-half, y, half}, {2 * half, 0, 0}, {0, 0, -2 * half}, material);
    else
        addQuad(scene, {-half, y, -half}, {2 * half, 0, 0}, {0, 0, 2 * half}, material);
}

struct Interface {
    double cosI, cosT, reflectance;
};

/// Fresnel's equations for light that is not polarised, from index n1 to n2.
Interface fresnel(double sinI, double cosI, double n1, double n2) {
    const double sinT = n1 / n2 * sinI;
    if (sinT >= 1.0) return {cosI, 0.0, 1.0};
    const double cosT = std::sqrt((1.0 - sinT) * (1.0 + sinT));
    const double s = (n1 * cosI - n2 * cosT) / (n1 * cosI + n2 * cosT),
                 p = (n2 * cosI - n1 * cosT) / (n2 * cosI + n1 * cosT);
    return {cosI, cosT, 0.5 * (s * s + p * p)};
}

Interface fresnelOf(const Camera& camera, double n1, double n2) {
    const dvec3 d = glm::normalize(dvec3(camera.forward));
    return fresnel(std::abs(d.x), std::abs(d.y), n1, n2);
}

const std::vector<double> angles = {0, 10, 20, 30, 40, 45, 50, 56.31, 60, 70, 80, 85, 89, 89.9, 89.99};

// A plane of glass between a ceiling that glows and a black floor: what is seen is what it reflects.
TEST_P(Optics, APlaneReflectsFresnelsShareAtEveryAngle) {
    for (const float ior : {1.5f, 1.33f, 2.4f}) {
        Scene scene;
        addLevel(scene, 0, true, glass(ior));
        addLevel(scene, 1, false, glowing(vec3(1.0f)));
        addLevel(scene, -1, true, glowing(vec3(0.0f)));
        for (const double degrees : angles) scene.cameras.push_back(ray(vec3(0), downAt(degrees), 0.5f));
        const std::vector<dvec3> seen = firstPixels(scene, 2);
        for (size_t i = 0; i < angles.size(); ++i)
            EXPECT_NEAR(seen[i].x, fresnelOf(scene.cameras[i], 1.0, double(ior)).reflectance, 2e-6)
                << "index " << ior << ", " << angles[i] << " degrees";
    }
}

/// A slab between y = 0 and -1 that absorbs: of each channel, by 1 / e in the lengths 2, 1 and 0.5.
Material absorbing(float ior) {
    Material m = glass(ior);
    m.attenuationColor = vec3(std::exp(-0.5f), std::exp(-1.0f), std::exp(-2.0f));
    m.attenuationDistance = 1.0f;
    return m;
}

// All that goes to and fro in the slab adds up to a geometric series: T^2 a / (1 - R^2 a^2) passes, and of what is mirrored,
// R + T^2 R a^2 / (1 - R^2 a^2) comes back, a being what is left of light after one way through.
TEST_P(Optics, ASlabPassesAndMirrorsWhatBeerLambertAndFresnelLeave) {
    for (const bool fromAbove : {true, false}) {
        Scene scene;
        constexpr float half = 16.0f;  // no larger than is needed, as rays leave a surface the farther off the larger it is
        addLevel(scene, 0, true, absorbing(1.5f), half);
        addLevel(scene, -1, false, absorbing(1.5f), half);
        addLevel(scene, 2, false, glowing(vec3(fromAbove ? 1.0f : 0.0f)));
        addLevel(scene, -3, true, glowing(vec3(fromAbove ? 0.0f : 1.0f)));
        const std::vector<double> some = {0, 15, 30, 45, 60, 75, 85, 89};
        for (const double degrees : some) scene.cameras.push_back(ray(vec3(0), downAt(degrees), 0.5f));
        const std::vector<dvec3> seen = firstPixels(scene, 40);
        for (size_t i = 0; i < some.size(); ++i) {
            const Interface at = fresnelOf(scene.cameras[i], 1.0, 1.5);
            const double r = at.reflectance, t = 1.0 - r;
            for (int channel = 0; channel < 3; ++channel) {
                const double a = std::exp(-(channel == 0 ? 0.5 : channel) / at.cosT), rest = 1.0 - r * r * a * a;
                const double want = fromAbove ? r + t * t * r * a * a / rest : t * t * a / rest;
                EXPECT_NEAR(seen[i][channel], want, 4e-6)
                    << some[i] << " degrees, channel " << channel << ", " << (fromAbove ? "mirrored" : "passed");
            }
        }
    }
}

/// A floor whose colour is its x, from 0 at `from` to 1 at `to`, lit so that it shows just that.
void addRuler(Scene& scene, float y, float from, float to) {
    const uint32_t floor = addQuad(scene, {from, y, 9}, {to - from, 0, 0}, {0, 0, -18}, matte(vec3(1.0f)));
    scene.meshes[floor].colors = {vec3(0), vec3(1), vec3(1), vec3(0)};
    scene.ambient = vec3(1.0f);
}

// A ray that passes a slab goes on in its direction, moved aside by Snell's law: a ruler behind it tells where.
TEST_P(Optics, ASlabMovesARayAsideBySnellsLaw) {
    for (const float ior : {1.5f, 2.4f}) {
        Scene scene;
        addLevel(scene, 2, true, glass(ior), 10.0f);
        addLevel(scene, 1, false, glass(ior), 10.0f);
        addRuler(scene, 0, -8, 8);
        const std::vector<double> some = {0, 10, 25, 40, 55, 70};
        for (const double degrees : some) scene.cameras.push_back(ray({0, 2, 0}, downAt(degrees), 0.5f));
        const std::vector<dvec3> seen = firstPixels(scene, 2);
        for (size_t i = 0; i < some.size(); ++i) {
            const Interface at = fresnelOf(scene.cameras[i], 1.0, double(ior));
            const double tanI = std::sqrt(1.0 - at.cosI * at.cosI) / at.cosI,
                         tanT = std::sqrt(1.0 - at.cosT * at.cosT) / at.cosT;
            const double passed = (1.0 - at.reflectance) * (1.0 - at.reflectance);
            EXPECT_NEAR(seen[i].x / passed * 16.0 - 8.0, tanT + tanI, 2e-5)
                << "index " << ior << ", " << some[i] << " degrees";
        }
    }
}

// Rays that come in parallel meet behind a ball at n R / (2 (n - 1)) from its centre [the paraxial focus], or before that by
// spherical aberration: one that comes in at height h leaves at that distance from the centre, too, turned by twice the
// difference of asin(h) and asin(h / n), and so crosses the axis at h / sin of that.
TEST_P(Optics, ABallBringsParallelRaysToItsFocus) {
    for (const float ior : {1.5f, 1.75f}) {
        const double n = ior, focus = n / (2.0 * (n - 1.0)), screen = 3.0;
        Scene scene;
        addTrueSphere(scene, vec3(0), 1.0f, glass(ior));
        addRuler(scene, -float(screen), -4, 4);
        const std::vector<float> heights = {1.0f / 64, 1.0f / 16, 0.125f, 0.25f, 0.5f, 0.75f};
        for (const float h : heights) scene.cameras.push_back(ray({h, 1.5f, 0}, {0, -1, 0}, 0.5f));
        const std::vector<dvec3> seen = firstPixels(scene, 2);
        for (size_t i = 0; i < heights.size(); ++i) {
            SCOPED_TRACE(heights[i]);
            const double h = heights[i], turn = 2.0 * (std::asin(h) - std::asin(h / n));
            const double passed = 1.0 - fresnel(h, std::sqrt(1.0 - h * h), 1.0, n).reflectance;
            const double x = seen[i].x / (passed * passed) * 8.0 - 4.0;
            EXPECT_NEAR(x, (h - screen * std::sin(turn)) / std::cos(turn), 1e-5);
            // Where the line from the screen back, turned by `turn`, crosses the axis.
            const double crossing = screen + x / std::tan(turn);
            EXPECT_NEAR(crossing, h / std::sin(turn), 1e-5 / std::tan(turn));
            EXPECT_LT(crossing, focus + 1e-5 / std::tan(turn));
            // Of third order the aberration is 0.28 h^2 of the focus at n = 1.5, and 0.19 h^2 at 1.75.
            EXPECT_GT(crossing, focus * (1.0 - h * h) - 1e-5 / std::tan(turn));
        }
    }
}

// Two mirrors of reflectance K that glow send each other glow / (1 - K) in the end.
TEST_P(Optics, FacingMirrorsComeToOneOverOneLessK) {
    for (const float k : {0.25f, 0.5f, 0.75f}) {
        Scene scene;
        Material mirror = metal(vec3(k));
        mirror.emission = vec3(0.125f);
        addLevel(scene, 1, false, mirror);
        addLevel(scene, -1, true, mirror);
        scene.cameras.push_back(ray(vec3(0), downAt(0), 0.5f));
        EXPECT_NEAR(firstPixels(scene, 64)[0].x, 0.125 / (1.0 - k), 2e-6) << k;
    }
}

INSTANTIATE_TEST_SUITE_P(, Optics, testing::ValuesIn(waysToTest()), testName);

}  // namespace
}  // namespace raig

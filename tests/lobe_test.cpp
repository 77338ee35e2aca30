// Light that rough surfaces mirror: how much it is in all, where it goes, and that lights are not counted twice; and shadows
// on smooth surfaces.
#include "base/random.hpp"
#include "rays/frame_kernels.hpp"
#include "reference/lobe.hpp"
#include "support/rendering.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// Code shared with devices, called by name.
shared::FrameKernels& code() {
    static shared::FrameKernels kernels;
    return kernels;
}

dvec3 onHemisphere(double cosine, double turn) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    return {sine * std::cos(turn), cosine, sine * std::sin(turn)};
}

/// The share of light from everywhere that a lobe reflects to an eye at that cosine, integrated.
double integral(const reference::Lobe& lobe, double roughness, double cosine) {
    const dvec3 n(0, 1, 0), eye = onHemisphere(cosine, 0.0);
    // By half vectors, which are where the lobe is: with the angle's tangent spread as the lobe's is.
    constexpr int steps = 400;
    const double a = roughness * roughness;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double u = (i + 0.5) / steps, tangent2 = a * a * u / (1.0 - u);
            const double nh = 1.0 / std::sqrt(1.0 + tangent2);
            const dvec3 h = onHemisphere(nh, 2.0 * M_PI * (j + 0.5) / steps);
            const double eh = glm::dot(eye, h);
            const dvec3 light = 2.0 * eh * h - eye;
            if (eh <= 0.0 || light.y <= 0.0) continue;
            const double d = a * a / (M_PI * std::pow(nh * nh * (a * a - 1.0) + 1.0, 2.0));
            const double density = d * nh / (4.0 * eh);
            sum += reference::lobeTowards(lobe, n, roughness, eye, light, 0.0).x * light.y / density;
        }
    return sum / (steps * steps);
}

TEST(Lobe, ReflectsOfLightFromEverywhereWhatItsAlbedoSays) {
    double squares = 0.0;
    int count = 0;
    for (const double r : {0.2, 0.35, 0.5, 0.7, 0.85, 1.0})
        for (const double cosine : {0.05, 0.15, 0.3, 0.5, 0.75, 1.0}) {
            const reference::Lobe perfect{dvec3(1.0), dvec3(1.0)}, grazing{dvec3(0.0), dvec3(1.0)};
            const reference::LobeAlbedo albedo = reference::lobeAlbedo(cosine, r);
            const double all = albedo.all - integral(perfect, r, cosine);
            const double edge = albedo.grazing - integral(grazing, r, cosine);
            EXPECT_LT(std::abs(all), 0.04) << r << ' ' << cosine;
            EXPECT_LT(std::abs(edge), 0.04) << r << ' ' << cosine;
            squares += all * all + edge * edge;
            count += 2;
        }
    EXPECT_LT(std::sqrt(squares / count), 0.02);
}

TEST(Lobe, IsTheReferencesInSinglePrecision) {
    Random random(4);
    double worst = 0.0;
    for (int i = 0; i < 20'000; ++i) {
        const auto r = static_cast<float>(random.unit());
        const vec3 along(random.unit(), random.unit(), random.unit());
        const dvec3 n = random.direction();
        dvec3 eye = random.direction(), light = random.direction();
        if (glm::dot(n, eye) < 0.0) eye = -eye;
        if (glm::dot(n, light) < 0.0) light = -light;
        if (i % 2 == 0) light = glm::normalize(2.0 * glm::dot(n, eye) * n - eye + 0.1 * random.unit() * light);
        if (std::min(glm::dot(n, light), glm::dot(n, eye)) < 0.01) continue;
        // Both get the same numbers: eye and light as they are rounded, as where the half vector points follows from their
        // lengths, too. The reference asks for a normal of unit length.
        const dvec3 e{vec3(eye)}, l{vec3(light)};
        const double want =
            reference::lobeTowards({dvec3(along), dvec3(1.0)}, glm::normalize(dvec3(vec3(n))), r, e, l, 0.01).x;
        const shared::FrameKernels::Lobe lobe{along, vec3(1.0f)};
        const double got = code().lobeTowards(lobe, vec3(n), r, vec3(eye), vec3(light), 0.01f).x;
        worst = std::max(worst, std::abs(got - want) / want);
        const reference::LobeAlbedo albedo = reference::lobeAlbedo(glm::dot(n, eye), r);
        const vec2 both = code().lobeAlbedo(static_cast<float>(glm::dot(n, eye)), r);
        EXPECT_NEAR(both.x, albedo.all, 1e-5);
        EXPECT_NEAR(both.y, albedo.grazing, 1e-5);
    }
    EXPECT_LT(worst, 5e-5);
}

// Along the normal D is 1 / (pi a^2), G 1 and F f0; a lamp without size is mirrored by the lobe alone, however smooth.
TEST(Lobe, MirrorsLampsWithoutSizeWhole) {
    for (const float r : {0.0f, 0.3f, 0.6f, 1.0f}) {
        Scene scene = floorFromAbove(metal(vec3(0.9f, 0.5f, 0.25f), r));
        scene.lights = {{.type = Light::Type::directional, .direction = {0, -1, 0}, .intensity = vec3(2.0f)}};
        const vec3 seen = Stage(scene).onCpu(square(1, 1)).radiance[0];
        const double a = std::max(0.01, double{r} * r);
        const reference::LobeAlbedo albedo = reference::lobeAlbedo(1.0, r);
        for (int k = 0; k < 3; ++k) {
            const double f0 = scene.materials[0].baseColor[k];
            const double want = 2.0 * f0 * (1.0 + f0 * (1.0 - albedo.all) / albedo.all) / (4.0 * M_PI * a * a);
            EXPECT_NEAR(seen[k], want, 1e-4 * want) << r;
        }
    }
}

// Below a dome of emitters of radiance 1 everything that keeps energy looks like 1, whether reflected rays or the lobe bring
// it: nothing is left out, nothing counted twice.
TEST(Lobe, AndReflectedRaysShareTheLightOfEmitters) {
    for (const Material& material : {metal(vec3(1.0f), 0.0f), metal(vec3(1.0f), 0.25f), metal(vec3(1.0f), 0.4f),
                                     metal(vec3(1.0f), 0.7f), matte(vec3(1.0f))}) {
        Scene scene = floorFromAbove(material);
        addSphere(scene, vec3(0.0f), 3.9f, 24, false, glowing(vec3(1.0f)));
        const Picture picture = Stage(scene).onCpu(square(16, 1024));
        double sum = 0.0;
        for (const vec3& c : picture.radiance) sum += c.x;
        EXPECT_NEAR(sum / 256.0, 1.0, 0.03) << material.metallic << ' ' << material.roughness;
    }
}

TEST(Lobe, OfRoughMetalIsSeenInLightFromEverywhere) {
    Scene scene = floorFromAbove(metal(vec3(0.8f, 0.4f, 0.2f), 0.9f));
    scene.ambient = vec3(1.0f);
    const vec3 seen = Stage(scene).onCpu(square(1, 1)).radiance[0];
    EXPECT_GT(seen.x, 0.6f);
    EXPECT_GT(seen.x, 1.5f * seen.y);
}

// ---- Shadows on smooth surfaces ----------------------------------------------------------------------------------------

// A ball of few facets, lit from aside, is as bright everywhere as its normals say: no facet shades its neighbour, or
// itself.
TEST(ShadowTerminator, FollowsTheNormalsNotTheFacets) {
    for (const float scale : {1.0f, 1e-3f, 1e4f}) {
        Scene scene;
        addSphere(scene, vec3(0.0f), scale, 5, true, matte(vec3(1.0f)));
        scene.lights = {{.type = Light::Type::directional, .direction = {-1, 0, 0}, .intensity = vec3(3.14159265f)}};
        scene.cameras.push_back(lookAt(vec3(0, 0, 4) * scale, vec3(0.0f)));
        const Stage stage(scene);
        const FrameOptions options = square(128, 1);
        const Picture picture = stage.onCpu(options);
        const std::vector<Ray> rays = cameraRays(stage.scene, options);
        const reference::World world(stage.scene, stage.geometry);
        size_t lit = 0, dark = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            const reference::Ray ray{rays[i].origin, rays[i].direction, 0.0, INFINITY};
            const reference::Hit hit = world.tree.closest(ray);
            if (hit.primitive == reference::noTriangle) continue;
            const reference::SurfacePoint p = reference::surfaceAt(world, ray, hit, 0.0);
            const double cosine = p.shadingNormal.x;
            if (cosine < 0.02) continue;
            ++lit;
            if (picture.radiance[i].x < 0.9 * cosine) ++dark;
        }
        EXPECT_GT(lit, 2000u);
        EXPECT_LE(dark, lit / 500) << scale;
    }
}

// Behind a wall that is as far from it as a facet's sagitta, the ball is dark all the same.
TEST(ShadowTerminator, LetsNoLightThroughWalls) {
    Scene scene;
    addSphere(scene, vec3(0.0f), 1.0f, 5, true, matte(vec3(1.0f)));
    addQuad(scene, {1.2f, -2, 2}, {0, 4, 0}, {0, 0, -4}, matte(vec3(0.0f)));
    scene.lights = {{.type = Light::Type::directional, .direction = {-1, 0, 0}, .intensity = vec3(3.14159265f)}};
    scene.cameras.push_back(lookAt(vec3(0, 0, 4), vec3(0.0f)));
    for (const vec3& c : Stage(scene).onCpu(square(96, 1)).radiance) ASSERT_EQ(c.x, 0.0f);
}

}  // namespace
}  // namespace raig

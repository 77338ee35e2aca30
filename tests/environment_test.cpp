// Light from a picture of all directions: what it amounts to, and that it is the same wherever it is asked for.
#include "base/random.hpp"
#include "image/image.hpp"
#include "measure/compare.hpp"
#include "rays/frame_data.hpp"
#include "rays/frame_kernels.hpp"
#include "reference/environment.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"
#include "support/rendering.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace raig {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

Environment constant(uint32_t side, const vec3& radiance) {
    return makeEnvironment(side, std::vector<vec3>(size_t{side} * side, radiance));
}

/// The unit direction of a point of the unfolded square, both in [-1, 1].
dvec3 directionOf(double u, double v) {
    const double y = 1.0 - std::abs(u) - std::abs(v);
    if (y >= 0.0) return glm::normalize(dvec3(u, y, v));
    return glm::normalize(dvec3(std::copysign(1.0 - std::abs(v), u), y, std::copysign(1.0 - std::abs(u), v)));
}

/// The solid angle of a texel: of many small triangles.
double solidAngleOf(uint32_t side, uint32_t column, uint32_t row) {
    constexpr int steps = 8;
    const auto corner = [&](int i, int j) {
        return directionOf(2.0 * (column + double(i) / steps) / side - 1.0, 2.0 * (row + double(j) / steps) / side - 1.0);
    };
    const auto triangle = [](const dvec3& a, const dvec3& b, const dvec3& c) {
        return 2.0 * std::atan2(std::abs(glm::dot(a, glm::cross(b, c))),
                                1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
    };
    double sum = 0.0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j)
            sum += triangle(corner(i, j), corner(i + 1, j), corner(i, j + 1)) +
                   triangle(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    return sum;
}

Environment varied(uint32_t side, uint64_t seed) {
    Random random(seed);
    std::vector<vec3> texels;
    for (uint32_t i = 0; i < side * side; ++i) {
        const float bright = i % 97 == 0 ? 30.0f : (i % 3 == 0 ? 0.0f : 0.5f);
        texels.push_back(bright * (random.inCube(0, 1)));
    }
    return makeEnvironment(side, std::move(texels));
}

// ---- The picture -------------------------------------------------------------------------------------------------------

TEST(Environment, SharesAreWholeAndLeaveNothingThatShinesOut) {
    for (const uint32_t side : {4u, 6u, 32u}) {
        std::vector<vec3> texels(size_t{side} * side, vec3(1e-20f));
        for (uint32_t i = 0; i < side; ++i) texels[size_t{1} * side + i] = vec3(0.0f);
        texels.back() = vec3(1e20f);
        const Environment environment = makeEnvironment(side, texels);
        EXPECT_EQ(environment.rows.back(), Environment::whole);
        for (uint32_t row = 0; row < side; ++row) {
            const uint32_t share = environment.rows[row] - (row > 0 ? environment.rows[row - 1] : 0);
            EXPECT_EQ(share > 0, row != 1);
            for (uint32_t column = 0; column < side; ++column) {
                const uint32_t* at = &environment.columns[size_t{row} * side + column];
                EXPECT_EQ(*at - (column > 0 ? at[-1] : 0) > 0, row != 1);
            }
            EXPECT_EQ(environment.columns[size_t{row} * side + side - 1], row == 1 ? 0 : Environment::whole);
        }
    }
    EXPECT_FALSE(constant(4, vec3(0.0f)).shines());
}

TEST(Environment, OfAnEquirectangularPictureLiesWhereItIsSaidTo) {
    // A different colour in each eighth of the picture's width, and the uppermost and lowest eighths of its height.
    std::vector<vec3> pixels(size_t{64} * 32);
    for (uint32_t y = 0; y < 32; ++y)
        for (uint32_t x = 0; x < 64; ++x) pixels[y * 64 + x] = {1.0f + float(x / 8), float(y < 4), float(y >= 28)};
    Scene scene;
    for (const double turn : {0.0, 90.0}) {
        scene.environment = fromEquirectangular(pixels, 64, 32, 2.0, turn * pi / 180.0);
        const auto seen = [&](double degreesRight, double height) {
            const double angle = degreesRight * pi / 180.0, flat = std::sqrt(1.0 - height * height);
            return vec3(0.5 * reference::distantRadiance(scene, {flat * std::sin(angle), height, -flat * std::cos(angle)}));
        };
        for (int eighth = 0; eighth < 8; ++eighth)
            EXPECT_EQ(seen(-157.5 + 45.0 * eighth - turn, 0.1), vec3(1.0f + float(eighth), 0, 0)) << turn;
        EXPECT_EQ(seen(20, 0.99).y, 1.0f);
        EXPECT_EQ(seen(20, -0.99).z, 1.0f);
        EXPECT_EQ(seen(20, -0.99).y, 0.0f);
    }
}

// However it is unfolded, as much light is there as was in the picture; and what is even stays so.
TEST(Environment, KeepsTheLightOfThePicture) {
    Random random(5);
    for (const uint32_t height : {1u, 8u, 100u}) {
        const uint32_t width = 2 * height;
        std::vector<vec3> pixels;
        for (uint32_t i = 0; i < width * height; ++i) pixels.push_back(random.inCube(0, 1));
        pixels[pixels.size() / 3] = vec3(500.0f);
        double want = 0.0, got = 0.0;
        for (uint32_t i = 0; i < pixels.size(); ++i) {
            const double from = pi * (i / width) / height, to = pi * (i / width + 1) / height;
            want += pixels[i].y * (std::cos(from) - std::cos(to)) * 2.0 * pi / width;
        }
        const Environment environment = fromEquirectangular(pixels, width, height, 1.0, 0.3);
        for (uint32_t i = 0; i < environment.texels.size(); ++i)
            got += environment.texels[i].y * solidAngleOf(environment.side, i % environment.side, i / environment.side);
        EXPECT_NEAR(got / want, 1.0, 0.02) << height;
        const std::vector<vec3> even(pixels.size(), vec3(0.25f));
        for (const vec3& texel : fromEquirectangular(even, width, height, 1.0, 0.0).texels)
            ASSERT_EQ(texel, vec3(0.25f));
    }
}

// ---- Its light ---------------------------------------------------------------------------------------------------------

Scene plane(float albedo) {
    Scene scene;
    addQuad(scene, {-50, 0, 50}, {100, 0, 0}, {0, 0, -100}, matte(vec3(albedo)));
    scene.cameras.push_back(lookAt({0, 4, 1}, {0, 0, 0}, 0.5f));
    return scene;
}

struct Mean {
    double value = 0.0;
    double error = 0.0;  ///< standard
};

Mean meanOf(const Picture& picture) {
    double sum = 0.0, squares = 0.0;
    const auto n = double(picture.radiance.size());
    for (const vec3& c : picture.radiance) sum += c.y, squares += double{c.y} * c.y;
    return {sum / n, std::sqrt(std::max(0.0, squares / n - sum * sum / n / n) / n)};
}

// In even light a diffuse surface is as bright as its albedo, whatever its shape and however coarse the light's picture.
TEST(EnvironmentLight, IsTheAlbedoInAFurnace) {
    for (const uint32_t side : {2u, 8u, 64u})
        for (const bool isBall : {false, true}) {
            Scene scene = plane(0.6f);
            if (isBall) {
                scene = Scene{};
                addTrueSphere(scene, vec3(0), 1.0f, matte(vec3(0.6f)));
                scene.cameras.push_back(lookAt({0.5f, 1, 4}, vec3(0), 0.3f));
            }
            scene.environment = constant(side, vec3(1.0f));
            const Mean mean = meanOf(Stage(scene).onCpu(square(64, 16)));
            EXPECT_LT(std::abs(mean.value - 0.6), 4.0 * mean.error) << side << ' ' << isBall;
            EXPECT_LT(mean.error, side == 2 ? 8e-3 : 2e-3);  // of four texels each is uneven in solid angle
        }
}

// A texel that shines alone is a sun: the same light, and the same shadow but for its rim, as a directional light's.
TEST(EnvironmentLight, OfOneTexelIsThatOfADirectionalLight) {
    constexpr uint32_t side = 512, column = 300, row = 290;
    Scene sun = plane(0.5f);
    addTrueSphere(sun, {0.1f, 0.5f, 0}, 0.4f, matte(vec3(0.5f)));
    Scene directional = sun;
    std::vector<vec3> texels(size_t{side} * side, vec3(0.0f));
    texels[row * side + column] = vec3(1e5f, 2e5f, 3e5f);
    sun.environment = makeEnvironment(side, texels);
    Light light;
    light.type = Light::Type::directional;
    const double u = 2.0 * (column + 0.5) / side - 1.0, v = 2.0 * (row + 0.5) / side - 1.0;
    light.direction = vec3(-directionOf(u, v));
    light.intensity = vec3(solidAngleOf(side, column, row) * dvec3(texels[row * side + column]));
    directional.lights.push_back(light);
    const Picture got = Stage(sun).onCpu(square(64, 16)), want = Stage(directional).onCpu(square(64, 16));
    size_t different = 0;
    for (size_t i = 0; i < got.radiance.size(); ++i)
        for (int k = 0; k < 3; ++k)
            different += std::abs(got.radiance[i][k] - want.radiance[i][k]) > 0.01f * want.radiance[i][k] + 1e-6f;
    EXPECT_LT(different, 3 * got.radiance.size() / 20) << "rims";
    EXPECT_NEAR(meanOf(got).value / meanOf(want).value, 1.0, 3e-3);
    EXPECT_EQ(got.statistics.shadowRays, want.statistics.shadowRays);
}

// What is drawn is what is seen: a direction drawn from a texel points to that texel, but for its rim.
TEST(EnvironmentLight, DrawsWhatIsSeen) {
    Scene scene = plane(1.0f);
    scene.environment = varied(46, 9);
    const FrameData data = packFrame(scene, flatten(scene));
    shared::FrameKernels code;
    code.FEATURES = data.features;
    code.frame = data.params;
    code.scene = data.elements;
    shared::FrameKernels::SurfacePoint p{};
    p.normal = p.shading = vec3(0, 1, 0);
    size_t drawn = 0, others = 0;
    for (uint32_t sample = 0; sample < 4096; ++sample) {
        const auto ray = code.environmentRay(p, 7, sample, 3);
        if (ray.light == vec3(0.0f)) continue;
        ++drawn;
        const vec3 seen = code.distantRadiance(ray.ray.direction);
        const double scale = ray.light.y / seen.y;
        others += !(std::abs(ray.light.x - scale * seen.x) < 1e-4 * ray.light.x);
        EXPECT_NEAR(glm::length(dvec3(ray.ray.direction)), 1.0, 1e-6);
    }
    EXPECT_GT(drawn, 1000u);
    EXPECT_LT(others, 3u);
}

/// Matte, glass, a mirror and smooth normals in a varied light.
Scene lit() {
    Scene scene = variedRoom();
    scene.ambient = vec3(0.0f);
    addSphere(scene, {-1.2f, 1, 0}, 0.8f, 10, true, matte({0.8f, 0.7f, 0.6f}));
    addTrueSphere(scene, {0.5f, 0.7f, 1}, 0.6f, glass(1.5f));
    addTrueSphere(scene, {1.8f, 1, -0.5f}, 0.8f, metal(vec3(0.9f)));
    addQuad(scene, {-0.5f, 3.9f, 0}, {1, 0, 0}, {0, 0, 1}, glowing(vec3(4.0f)));
    scene.environment = varied(30, 4);
    return scene;
}

TEST(EnvironmentLight, MakesThePictureOfTheReference) {
    const Stage stage(lit());
    const reference::World world(stage.scene, stage.geometry);
    const Picture picture = stage.onCpu(square(40, 2, 6));
    reference::PictureOptions same;
    same.width = same.height = 40;
    same.samples = 2;
    same.bounds = {6, 0.0f, 0};
    const reference::Picture expected = reference::render(world, same);
    Image image(40, 40);
    image.pixels = picture.radiance;
    const PictureComparison got = compareToReference(image, expected);
    EXPECT_LT(got.outsideTies.rmse, 1e-3);
    EXPECT_EQ(got.outsideTies.nan, 0u);
    EXPECT_LT(got.ties, 40u * 40u / 3);
    EXPECT_FALSE(got.blank);
}

class EnvironmentOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, EnvironmentOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(EnvironmentOnDevice, LooksAsOnTheCpuToTheBit) {
    const Stage stage(lit());
    Device device(info);
    const auto tracer = makeDeviceTracer(device, stage.structure);
    const FrameOptions options = square(32, 3, 6);
    EXPECT_EQ(bitsOf(renderPicture(device, stage.scene, stage.geometry, *tracer, options)), bitsOf(stage.onCpu(options)));
}

// ---- The command line --------------------------------------------------------------------------------------------------

TEST(EnvironmentCommand, TakesThePlaceOfWhatStandsInForLight) {
    const Folder folder;
    const std::string scene =
        folder.write("square.obj", "v -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\nf 1 2 3 4\n").string();
    const std::string sky = folder.write("sky.pfm", "").string(), out = folder.write("out.pfm", "").string();
    Image even(4, 2, vec3(0.5f));
    even.pixels[3].x = -1.0f;
    writePicture(sky, even);
    const auto render = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = {"render", scene, "-o",  out,        "--size", "32x32", "--eye", "0,2,1",
                                              "--at",   "0,0,0", "--spp", "16", "--device", "cpu"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runProgram(RAIG_PROGRAM, arguments);
    };
    const ProgramResult lit = render({"--environment", sky, "--environment-scale", "4"});
    ASSERT_EQ(lit.exitCode, 0) << lit.errors;
    EXPECT_NE(lit.errors.find("1 of its pixels are negative"), std::string::npos) << lit.errors;
    EXPECT_EQ(lit.errors.find("headlight"), std::string::npos) << lit.errors;
    Mean mean;
    for (const vec3& c : readPicture(out).pixels) mean.value += c.y / 1024.0;
    EXPECT_NEAR(mean.value, 0.8 * 2.0 * 3.0 / 4.0, 0.05) << "a grey of 0.8, under light of 2, but for a quarter of the sky";

    const std::string bad = folder.write("bad.hdr", "#?RADIANCE\nnothing").string();
    for (const auto& [arguments, code] : std::vector<std::pair<std::vector<std::string>, int>>{
             {{"--environment", bad}, 3},
             {{"--environment", sky + ".missing"}, 3},
             {{"--environment", scene}, 3},
             {{"--environment-scale", "2"}, 2},
             {{"--environment", sky, "--environment-scale", "-1"}, 2},
             {{"--environment", sky, "--environment-rotate", "much"}, 2}}) {
        const ProgramResult result = render(arguments);
        EXPECT_EQ(result.exitCode, code) << arguments[1] << result.errors;
        EXPECT_EQ(std::ranges::count(result.errors, '\n'), 1) << result.errors;
    }
}

}  // namespace
}  // namespace raig

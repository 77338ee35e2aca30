#include "support/ways.hpp"

#include "reference/picture.hpp"
#include "reference/world.hpp"

#include <cmath>

namespace raig::test {

std::vector<std::string> waysToTest() {
    std::vector<std::string> ways = {"cpu", "reference"};
    for (const std::string& device : devicesToTest()) ways.push_back(device);
    return ways;
}

struct WayOfScene::State {
    explicit State(const Scene& scene) : stage(scene) {}

    Stage stage;
    std::unique_ptr<reference::World> world;
    std::unique_ptr<Device> device;
    std::unique_ptr<Tracer> tracer;
    std::unique_ptr<DeviceTracer> deviceTracer;
    std::unique_ptr<DeviceFrame> frame;
};

WayOfScene::WayOfScene(const std::string& way, const Scene& scene) : state_(std::make_unique<State>(scene)) {
    State& s = *state_;
    if (way == "reference") {
        s.world = std::make_unique<reference::World>(s.stage.scene, s.stage.geometry);
    } else if (way == "cpu") {
        s.tracer = makeCpuTracer(s.stage.structure);
    } else {
        s.device = std::make_unique<Device>(findDevice(way).value());
        s.deviceTracer = makeDeviceTracer(*s.device, s.stage.structure, /* counts= */ false);
        s.frame = std::make_unique<DeviceFrame>(*s.device, s.stage.scene, s.stage.geometry, *s.deviceTracer);
    }
}

WayOfScene::~WayOfScene() = default;

std::vector<dvec3> WayOfScene::render(const FrameOptions& options) {
    State& s = *state_;
    if (s.world) {
        reference::PictureOptions same;
        same.width = options.width;
        same.height = options.height;
        same.samples = options.samples;
        same.camera = options.camera;
        same.bounds = {options.maxDepth, options.minContribution, options.seed};
        same.integrator = options.integrator;
        same.reach = options.reach;
        same.roundings = 0;
        return reference::render(*s.world, same).radiance;
    }
    const Picture picture =
        s.frame ? s.frame->render(options) : renderPicture(s.stage.scene, s.stage.geometry, *s.tracer, options);
    return {picture.radiance.begin(), picture.radiance.end()};
}

void ByEveryWay::SetUp() {
    const std::string& way = GetParam();
    if (way != "cpu" && way != "reference" && !findDevice(way)) GTEST_SKIP() << "there is no device " << way;
}

std::vector<dvec3> ByEveryWay::firstPixels(const Scene& scene, uint32_t maxDepth) const {
    WayOfScene way(GetParam(), scene);
    std::vector<dvec3> pixels;
    for (uint32_t camera = 0; camera < scene.cameras.size(); ++camera) {
        FrameOptions options = square(1, 1, maxDepth);
        options.camera = camera;
        pixels.push_back(way.render(options).at(0));
    }
    return pixels;
}

Sample sampleOf(const std::vector<double>& values) {
    Sample sample;
    sample.count = values.size();
    for (const double value : values) sample.mean += value / double(values.size());
    double squares = 0.0;
    for (const double value : values) squares += (value - sample.mean) * (value - sample.mean);
    sample.error = std::sqrt(squares / double(values.size() - 1) / double(values.size()));
    return sample;
}

void expectMean(const Sample& sample, double want, double precision) {
    // Of Student's distribution with 31 degrees of freedom, outside of which 1e-4 is; with more it would be less.
    constexpr double t = 4.461;
    ASSERT_GE(sample.count, 32u);
    EXPECT_NEAR(sample.mean, want, t * sample.error);
    EXPECT_LT(t * sample.error, precision * want) << "the test could not tell";
}

void expectTheReferences(const Stage& stage, uint32_t side, uint32_t depth) {
    const Picture got = stage.onCpu(square(side, 2, depth));
    const reference::World world(stage.scene, stage.geometry);
    reference::PictureOptions options;
    options.width = options.height = side;
    options.samples = options.roundings = 2;
    options.bounds = {.maxDepth = depth, .minContribution = 0.0f};
    const reference::Picture want = reference::render(world, options);
    size_t compared = 0;
    for (size_t i = 0; i < got.radiance.size(); ++i) {
        if (!(want.sensitivity[i] < 1e-4)) continue;
        ++compared;
        for (int k = 0; k < 3; ++k)
            ASSERT_NEAR(got.radiance[i][k], want.radiance[i][k], 2e-4 * std::max(1.0, want.radiance[i][k])) << "pixel " << i;
        ASSERT_NEAR(got.discarded[i], want.discarded[i], 1e-4) << "pixel " << i;
    }
    EXPECT_GT(compared, got.radiance.size() * 3 / 4);
}

void expectTheCpusBits(Device& device, const Stage& stage, FrameOptions options) {
    const auto tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    EXPECT_EQ(bitsOf(frame.render(options)), bitsOf(stage.onCpu(options)));
    const FrameOptions whitted = square(32, 1);
    EXPECT_EQ(bitsOf(frame.render(whitted)), bitsOf(stage.onCpu(whitted)));
    options.tilePixels = 100;
    options.countsCosts = true;
    const Picture got = frame.render(options), want = stage.onCpu(options);
    EXPECT_EQ(bitsOf(got), bitsOf(want));
    EXPECT_EQ(got.costs, want.costs);
    options.countsCosts = false;
    options.tolerance = 0.1;
    options.samples = 32;
    EXPECT_EQ(bitsOf(frame.render(options)), bitsOf(stage.onCpu(options)));
}

}  // namespace raig::test

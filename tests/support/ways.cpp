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

}  // namespace raig::test

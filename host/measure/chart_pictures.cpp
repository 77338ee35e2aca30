#include "measure/chart_pictures.hpp"

#include "image/metrics.hpp"
#include "measure/compare.hpp"
#include "measure/timing.hpp"
#include "rays/frame.hpp"
#include "rays/lights.hpp"

#include <chrono>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t samples = 4;

}  // namespace

ChartPictures picturesOf(const ChartScene& scene, Device* device, uint32_t side, uint32_t seed) {
    Structure structure = structureType("bvh").build(scene.primitives(), {});
    markSeeThrough(scene.scene(), scene.geometry(), structure);
    std::unique_ptr<DeviceTracer> onDevice = device ? makeDeviceTracer(*device, structure) : nullptr;
    const std::unique_ptr<Tracer> onCpu = device ? nullptr : makeCpuTracer(structure);
    FrameOptions frame;
    frame.width = frame.height = side;
    frame.samples = samples;
    frame.seed = seed;

    Clock::time_point start = Clock::now();
    const Picture picture = device ? renderPicture(*device, scene.scene(), scene.geometry(), *onDevice, frame)
                                   : renderPicture(scene.scene(), scene.geometry(), *onCpu, frame);
    const double deviceSeconds = secondsSince(start);
    start = Clock::now();
    reference::PictureOptions options;
    options.width = options.height = side;
    options.samples = samples;
    options.bounds = {frame.maxDepth, frame.minContribution, seed};
    options.roundings = 0;
    const reference::Picture expected = reference::render(scene.world(), options);
    const double referenceSeconds = secondsSince(start);

    Image image(side, side);
    image.pixels = picture.radiance;
    const Image rounded = roundedImage(expected);
    const PictureDifference d = comparePictures(image, rounded);
    const std::vector<Ray> rays = cameraRays(scene.scene(), frame);
    std::vector<Hit> hits(rays.size());
    (onDevice ? static_cast<Tracer&>(*onDevice) : *onCpu).trace(rays, hits, Query::closest);
    const HitComparison compared = compareHits(scene.world().tree, rays, hits);
    ChartPictures result{scene.name(), side, side, {}, {}, {}, {}};
    result.device = encodePicture(image, PictureFormat::png);
    result.reference = encodePicture(rounded, PictureFormat::png);
    result.difference = encodePicture(falseColour(flipValues(image, rounded), side, side), PictureFormat::png);
    result.numbers = {{"rmse", d.rmse},
                      {"flip_mean", d.flipMean},
                      {"flip_p99", d.flipP99},
                      {"nan", d.nan},
                      {"missed", compared.count(HitClass::missed)},
                      {"phantom", compared.count(HitClass::phantom)},
                      {"wrong", compared.count(HitClass::wrong)},
                      {"device_s", deviceSeconds},
                      {"reference_s", referenceSeconds}};
    return result;
}

}  // namespace raig

#include "base/error.hpp"
#include "measure/compare.hpp"
#include "measure/tasks.hpp"
#include "measure/timing.hpp"
#include "rays/adaptive.hpp"
#include "rays/frame.hpp"
#include "rays/lights.hpp"
#include "scene/integrator.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <map>

namespace raig {

namespace {

constexpr double unbounded = 1e-6;  // a reference picture follows rays until their weight is below this
constexpr double usual = 1.0 / 512.0;
constexpr uint32_t deepest = 64;
constexpr uint32_t depthSide = 64;  // of the picture that mean depths are counted in

/// A scene on the device, and reference pictures of it.
class Stage {
public:
    Stage(const ChartScene& scene, Device* device)
        : scene_(scene), structure_(structureType("bvh").build(scene.primitives(), {})) {
        markSeeThrough(scene.scene(), scene.geometry(), structure_);
        canDraw_ = device && device->draws();
        if (device) {
            onDevice_ = makeDeviceTracer(*device, structure_);
            frame_ = std::make_unique<DeviceFrame>(*device, scene.scene(), scene.geometry(), *onDevice_);
        } else {
            onCpu_ = makeCpuTracer(structure_);
        }
        reach_ = suitableReach(scene.scene(), onDevice_ ? *onDevice_ : *onCpu_, {});
    }

    /// `draws`: camera rays are told what an item buffer shows. Throws limitError where nothing can be drawn.
    Picture render(FrameOptions options, bool draws) {
        if (draws && !canDraw_) throw limitError("there is no device that draws");
        if (draws) options.itemsOf = &structure_;
        return frame_ ? frame_->render(options) : renderPicture(scene_.scene(), scene_.geometry(), *onCpu_, options);
    }

    /// With `samples` a pixel; kept until the scene is forgotten.
    const reference::Picture& reference(Integrator integrator, uint32_t side, uint32_t samples,
                                        const reference::Bounds& bounds) {
        const auto key = std::tuple(integrator, side, samples, bounds.maxDepth, bounds.minContribution, bounds.seed);
        const auto known = references_.find(key);
        if (known != references_.end()) return known->second;
        // Pixels that rounding can change are found where each has one sample: then edges are not averaged.
        const uint32_t roundings = samples == 1 ? 4 : 0;
        return references_.emplace(key, renderReference(integrator, side, samples, bounds, roundings)).first->second;
    }

    reference::Picture renderReference(Integrator integrator, uint32_t side, uint32_t samples,
                                       const reference::Bounds& bounds, uint32_t roundings) const {
        reference::PictureOptions options;
        options.integrator = integrator;
        options.reach = reach();
        options.width = options.height = side;
        options.samples = samples;
        options.bounds = bounds;
        options.roundings = roundings;
        return reference::render(scene_.world(), options);
    }

    /// How far ambient occlusion looks.
    float reach() const { return reach_; }

private:
    const ChartScene& scene_;
    Structure structure_;
    bool canDraw_ = false;
    std::unique_ptr<DeviceTracer> onDevice_;
    std::unique_ptr<Tracer> onCpu_;
    std::unique_ptr<DeviceFrame> frame_;
    float reach_ = INFINITY;
    std::map<std::tuple<Integrator, uint32_t, uint32_t, uint32_t, float, uint32_t>, reference::Picture> references_;
};

double largest(const vec3& v) {
    return std::max({v.x, v.y, v.z});
}

double meanOf(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return values.empty() ? 0.0 : sum / double(values.size());
}

/// Throws usageError if there is none of that name.
Integrator integratorOf(const Json& settings) {
    const std::string name = textOf(settings, "integrator", "whitted");
    const auto named = std::ranges::find(integratorNames, name);
    if (named == integratorNames.end())
        throw usageError("the setting \"integrator\" takes {}, not \"{}\"", fmt::join(integratorNames, ", "), name);
    return static_cast<Integrator>(named - integratorNames.begin());
}

class PictureTask : public Task {
public:
    explicit PictureTask(const TaskSettings& settings) : settings_(settings) {}

    bool needsScene() const override { return true; }

    void check(const Json& settings) const override {
        checkSettings(settings, "picture",
                      {"max-depth", "min-contribution", "spp", "adaptive", "pictures", "side", "reference-spp", "repeat"},
                      {"primary", "integrator"});
        integratorOf(settings);
        const std::string primary = textOf(settings, "primary", "ray");
        if (primary != "ray" && primary != "raster")
            throw usageError("the setting \"primary\" takes ray or raster, not \"{}\"", primary);
        const auto whole = [&](const char* name, double low, double high) {
            const double value = numberOf(settings, name, low);
            if (!(value >= low && value <= high && value == std::floor(value)))
                throw usageError("the setting \"{}\" takes a whole number from {} to {}", name, low, high);
        };
        whole("max-depth", 0, 64);
        whole("spp", 1, 65536);
        whole("pictures", 1, 4096);
        whole("side", 1, 4096);
        whole("reference-spp", 1, 65536);
        whole("repeat", 1, 1000);
        const double tolerance = numberOf(settings, "adaptive", 1.0);
        if (!(tolerance > 0.0 && std::isfinite(tolerance)))
            throw usageError("the setting \"adaptive\" takes an error above 0");
        if (settings.contains("adaptive") && numberOf(settings, "spp", 1) < firstSamples)
            throw usageError("the setting \"adaptive\" wants an \"spp\" of {} or more", firstSamples);
        const double contribution = numberOf(settings, "min-contribution", 0.0);
        if (!(contribution >= 0.0 && contribution <= 1.0))
            throw usageError("the setting \"min-contribution\" takes a number from 0 to 1");
    }

    Json run(const ChartScene* scene, const Json& settings) override {
        if (!stage_) stage_ = std::make_unique<Stage>(*scene, settings_.device);
        const auto side = static_cast<uint32_t>(numberOf(settings, "side", 256));
        const auto referenceSamples = static_cast<uint32_t>(numberOf(settings, "reference-spp", 1));
        FrameOptions frame;
        frame.width = frame.height = side;
        frame.samples = static_cast<uint32_t>(numberOf(settings, "spp", 1));
        frame.tolerance = numberOf(settings, "adaptive", 0.0);
        frame.maxDepth = static_cast<uint32_t>(numberOf(settings, "max-depth", 8));
        frame.minContribution = static_cast<float>(numberOf(settings, "min-contribution", usual));
        frame.seed = settings_.seed;
        frame.integrator = integratorOf(settings);
        frame.reach = stage_->reach();
        const bool comparesNoise = referenceSamples > 1;
        const reference::Bounds bounds = referenceBounds(frame, comparesNoise);
        const reference::Picture& expected = stage_->reference(frame.integrator, side, referenceSamples, bounds);
        draws_ = textOf(settings, "primary", "ray") == "raster";
        Picture picture;
        const double seconds = render(frame, static_cast<uint32_t>(numberOf(settings, "pictures", 1)),
                                      static_cast<uint32_t>(numberOf(settings, "repeat", 3)), picture);
        const double samples = samplesOf(picture, frame.samples), pixels = double(side) * side;
        const auto closest = double(picture.statistics.closestRays), shadow = double(picture.statistics.shadowRays);
        Json measures = {{"samples", samples * numberOf(settings, "pictures", 1)},
                         {"seconds", seconds},
                         {"rays_per_sample", closest / samples / pixels},
                         {"shadow_rays_per_sample", shadow / samples / pixels},
                         {"rays_per_pixel", (closest + shadow) / pixels},
                         {"unsettled", picture.statistics.unsettled}};
        addPrimaries(picture, frame, measures);
        compare(picture, expected, !comparesNoise && frame.samples == 1, measures);
        if (frame.integrator == Integrator::whitted)
            compareToBound(picture, expected, !comparesNoise && frame.samples == 1, measures);
        const reference::Picture deep = stage_->renderReference(
            frame.integrator, depthSide, 1, {frame.maxDepth, frame.minContribution, bounds.seed}, 0);
        measures["mean_depth"] = meanOf(deep.depth);
        if (scene->mirrorReflectance) compareToClosedForm(picture, *scene->mirrorReflectance, frame.maxDepth, measures);
        return measures;
    }

    void forgetScene() override { stage_.reset(); }

    const Json& measures() const override {
        static const Json all = {{"samples", "samples a pixel"},
                                 {"seconds", "s a picture"},
                                 {"rays_per_sample", "camera, mirrored and transmitted rays a sample"},
                                 {"shadow_rays_per_sample", "shadow rays a sample"},
                                 {"rays_per_pixel", "rays a pixel"},
                                 {"unsettled", "pixels whose error is above the tolerance"},
                                 {"camera_milliseconds", "ms for camera rays, drawing included"},
                                 {"draw_milliseconds", "ms of drawing"},
                                 {"fallback_percent", "% of camera rays that met other than was drawn"},
                                 {"differing", "pixels with other bits than those of traced camera rays"},
                                 {"rmse", "RMSE, linear light"},
                                 {"relmse", "relMSE"},
                                 {"flip_mean", "FLIP, mean"},
                                 {"flip_p99", "FLIP, 99 % of pixels"},
                                 {"flip_max", "FLIP, largest"},
                                 {"mean_error", "mean error, linear light"},
                                 {"max_error", "largest error, linear light"},
                                 {"bound_mean", "discarded weight times brightest radiance, mean"},
                                 {"bound_max", "the same, largest"},
                                 {"discarded_mean", "discarded weight, mean"},
                                 {"discarded_max", "discarded weight, largest"},
                                 {"beyond_bound", "pixels whose error exceeds their bound"},
                                 {"ties", "pixels left out: rounding decides them"},
                                 {"nan", "pixels that are not finite"},
                                 {"mean_depth", "mean depth used"},
                                 {"relative_error", "error of the whole"},
                                 {"theory", "Kᴺ⁺¹"}};
        return all;
    }

private:
    /// How far the reference follows rays, and by which random numbers. Noise is measured against others, all else being the
    /// picture's, so that nothing else differs. What bounds leave out is measured against rays that go on while they matter,
    /// by the same numbers, so that noise cancels.
    static reference::Bounds referenceBounds(const FrameOptions& frame, bool comparesNoise) {
        if (comparesNoise) return {frame.maxDepth, frame.minContribution, frame.seed + 0x5eed};
        // Paths have no bias however early they end by chance.
        const double contribution = frame.integrator == Integrator::path ? usual : unbounded;
        return {deepest, static_cast<float>(contribution), frame.seed};
    }

    /// Of a pixel, on average.
    static double samplesOf(const Picture& picture, uint32_t ofEach) {
        double sum = 0.0;
        for (const uint32_t samples : picture.samples) sum += samples;
        return picture.samples.empty() ? ofEach : sum / double(picture.samples.size());
    }

    /// Of the first ray of each pixel, the only one that is told apart: how long it took, and how often it was led astray.
    void addPrimaries(const Picture& picture, const FrameOptions& frame, Json& measures) {
        const FrameStatistics& s = picture.statistics;
        measures.update({{"camera_milliseconds", cameraMilliseconds_},
                         {"draw_milliseconds", 1e3 * s.drawSeconds},
                         {"fallback_percent", s.hintedRays ? 100.0 * double(s.fallbacks) / double(s.hintedRays) : 0.0},
                         {"differing", 0}});
        if (!draws_) return;
        const Picture traced = stage_->render(frame, false);
        uint64_t differing = 0;
        for (size_t i = 0; i < traced.radiance.size(); ++i)
            differing += std::memcmp(&traced.radiance[i], &picture.radiance[i], sizeof(vec3)) != 0;
        measures["differing"] = differing;
    }

    /// The mean of `pictures` pictures, of seeds one after the other. Returns the time it took: of one picture the median of
    /// `repeat` times.
    double render(FrameOptions frame, uint32_t pictures, uint32_t repeat, Picture& mean) {
        std::vector<double> seconds, camera;
        for (uint32_t i = 0; i < repeat; ++i) {
            const auto start = std::chrono::steady_clock::now();
            mean = stage_->render(frame, draws_);
            camera.push_back(1e3 * (mean.statistics.firstSeconds + mean.statistics.drawSeconds));
            for (uint32_t k = 1; k < pictures && i == 0; ++k) {
                FrameOptions other = frame;
                other.seed = frame.seed + k;
                const Picture more = stage_->render(other, draws_);
                for (size_t p = 0; p < mean.radiance.size(); ++p) {
                    mean.radiance[p] += more.radiance[p];
                    mean.discarded[p] += more.discarded[p];
                }
            }
            seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            if (pictures > 1) {
                for (vec3& radiance : mean.radiance) radiance /= static_cast<float>(pictures);
                for (float& discarded : mean.discarded) discarded /= static_cast<float>(pictures);
                break;
            }
            if (seconds.back() > 2.0) break;  // what takes so long is not noise
        }
        cameraMilliseconds_ = quartilesOf(camera).median;
        return quartilesOf(seconds).median;
    }

    /// Errors against the reference; `leavesOutTies`: pixels where rounding decides are none of theirs.
    static void compare(const Picture& picture, const reference::Picture& expected, bool leavesOutTies, Json& measures) {
        Image image(picture.width, picture.height);
        image.pixels = picture.radiance;
        const PictureComparison found = compareToReference(image, expected);
        const PictureDifference& d = leavesOutTies ? found.outsideTies : found.everywhere;
        measures.update({{"rmse", d.rmse},
                         {"relmse", d.relmse},
                         {"flip_mean", d.flipMean},
                         {"flip_p99", d.flipP99},
                         {"flip_max", d.flipMax},
                         {"ties", leavesOutTies ? found.ties : 0},
                         {"nan", found.everywhere.nan}});
    }

    /// Errors against what discarded weight allows.
    static void compareToBound(const Picture& picture, const reference::Picture& expected, bool leavesOutTies,
                               Json& measures) {
        const double brightest = *std::max_element(expected.brightest.begin(), expected.brightest.end());
        double sum = 0.0, most = 0.0, boundSum = 0.0, boundMost = 0.0, discardedSum = 0.0, discardedMost = 0.0;
        uint64_t beyond = 0, compared = 0;
        for (size_t i = 0; i < picture.radiance.size(); ++i) {
            if (leavesOutTies && expected.sensitivity[i] > tieSensitivity) continue;
            const double error = largest(glm::abs(picture.radiance[i] - vec3(expected.radiance[i])));
            const double discarded = picture.discarded[i], bound = discarded * brightest;
            ++compared;
            sum += error;
            most = std::max(most, error);
            boundSum += bound;
            boundMost = std::max(boundMost, bound);
            discardedSum += discarded;
            discardedMost = std::max(discardedMost, discarded);
            // What rounding may do to a pixel that is no tie comes on top, as does what the reference leaves out.
            beyond += error > bound + tieSensitivity + expected.discarded[i] * brightest;
        }
        const double count = double(std::max<uint64_t>(compared, 1));
        measures.update({{"mean_error", sum / count},
                         {"max_error", most},
                         {"bound_mean", boundSum / count},
                         {"bound_max", boundMost},
                         {"discarded_mean", discardedSum / count},
                         {"discarded_max", discardedMost},
                         {"beyond_bound", beyond}});
    }

    static void compareToClosedForm(const Picture& picture, double reflectance, uint32_t depth, Json& measures) {
        const double whole = 1.0 / (1.0 - reflectance);
        double most = 0.0;
        for (const vec3& radiance : picture.radiance)
            for (int channel = 0; channel < 3; ++channel) {
                const double error = std::abs(radiance[channel] - whole) / whole;
                if (!(error <= most)) most = error;  // also if it is no number
            }
        measures["relative_error"] = most;
        measures["theory"] = std::pow(reflectance, depth + 1.0);
    }

    TaskSettings settings_;
    bool draws_ = false;               ///< in the point at hand
    double cameraMilliseconds_ = 0.0;  ///< of the last render()
    std::unique_ptr<Stage> stage_;
};

}  // namespace

std::unique_ptr<Task> makePictureTask(const TaskSettings& settings) {
    return std::make_unique<PictureTask>(settings);
}

}  // namespace raig

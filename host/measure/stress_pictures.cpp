#include "measure/stress_pictures.hpp"

#include "base/error.hpp"
#include "measure/corruption.hpp"
#include "measure/hard_meshes.hpp"
#include "rays/lights.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>

namespace raig {

namespace {

constexpr size_t mostExamples = 3;
constexpr double soon = 20.0;  // seconds

bool endsRun(const Error& error) {
    return error.exitCode == ExitCode::noDevice || error.exitCode == ExitCode::limit;
}

uint64_t pixelsOf(const hard::PictureScene& scene) {
    if (scene.isRefused) return 1;
    uint64_t pixels = 0;
    for (const FrameOptions& options : scene.options) pixels += uint64_t{options.width} * options.height;
    return pixels;
}

bool sameBits(const Picture& a, const Picture& b, size_t pixel) {
    return std::memcmp(&a.radiance[pixel], &b.radiance[pixel], sizeof(vec3)) == 0 &&
           std::memcmp(&a.discarded[pixel], &b.discarded[pixel], sizeof(float)) == 0;
}

bool isNumber(const Picture& picture, size_t pixel) {
    const vec3 c = picture.radiance[pixel];
    return std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z) && std::isfinite(picture.discarded[pixel]);
}

/// Pictures of a scene by one subject, or what was thrown instead.
struct Rendered {
    std::vector<Picture> pictures;
    StressFault fault = StressFault::none;
    std::string thrown;
    std::optional<Error> stopped;
    double seconds = 0.0;
};

Rendered renderAll(const PictureSubject& subject, const hard::PictureScene& scene) {
    Rendered rendered;
    const auto fail = [&](StressFault fault, const std::string& what) {
        rendered.fault = fault;
        rendered.thrown = what;
    };
    const auto start = std::chrono::steady_clock::now();
    try {
        rendered.pictures = subject.render(scene);
        if (scene.isRefused) fail(StressFault::wrong, "was not refused");
    } catch (const CorruptStructure& corrupt) {
        fail(StressFault::hung, corrupt.what());
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const Error& error) {
        const bool isRefusal = scene.largestBinding > 0 && error.exitCode == ExitCode::limit;
        if (!isRefusal) fail(StressFault::error, error.what());
        if (!isRefusal && endsRun(error)) rendered.stopped = error;
    } catch (const std::exception& other) {
        fail(StressFault::error, other.what());
    }
    rendered.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return rendered;
}

/// Counts what is wrong in the pictures of a scene.
class Judging {
public:
    Judging(StressResult& result, const hard::PictureScene& scene, const Rendered& rendered, const Rendered* yardstick)
        : result_(result), scene_(scene), rendered_(rendered), yardstick_(yardstick) {}

    void judge() {
        const uint64_t pixels = pixelsOf(scene_);
        if (rendered_.fault != StressFault::none) {
            count(rendered_.fault, pixels, 0, rendered_.thrown);
        } else {
            for (size_t i = 0; i < rendered_.pictures.size(); ++i) judgePicture(i);
        }
        result_.rays += pixels;
        result_.seconds += rendered_.seconds;
    }

private:
    void judgePicture(size_t number) {
        const Picture& picture = rendered_.pictures[number];
        const FrameOptions& options = scene_.options[number];
        const bool isCompared = yardstick_ != nullptr && number < yardstick_->pictures.size();
        for (size_t pixel = 0; pixel < picture.radiance.size(); ++pixel) {
            const uint64_t at = first_ + pixel;
            const std::string wrong =
                isNumber(picture, pixel) ? scene_.fault(picture, options, pixel) : std::string("no number");
            const bool sameAsOthers = !isCompared || sameBits(picture, yardstick_->pictures[number], pixel);
            const bool sameAsFirst = !scene_.sameBits || sameBits(picture, rendered_.pictures[0], pixel);
            const auto where = [&] {
                return fmt::format("{} x {}, pixel ({}, {})", options.width, options.height, pixel % options.width,
                                   pixel / options.width);
            };
            if (!wrong.empty())
                count(StressFault::wrong, 1, at, where() + ": " + wrong);
            else if (!sameAsOthers || !sameAsFirst)
                count(StressFault::differs, 1, at, where() + (sameAsFirst ? ": other bits than brute's" : ": other bits"));
        }
        first_ += picture.radiance.size();
    }

    void count(StressFault fault, uint64_t pixels, uint64_t at, const std::string& what) {
        result_.faulty += pixels;
        result_.counts[static_cast<size_t>(fault)] += pixels;
        if (result_.examples.size() < mostExamples)
            result_.examples.push_back({result_.rays + at, scene_.name, fault, what});
    }

    StressResult& result_;
    const hard::PictureScene& scene_;
    const Rendered& rendered_;
    const Rendered* yardstick_;
    uint64_t first_ = 0;  ///< pixel of the scene
};

std::vector<Picture> renderOnCpu(const hard::PictureScene& scene, const Geometry& geometry, const Structure& structure) {
    const std::unique_ptr<Tracer> tracer = makeCpuTracer(structure);
    std::vector<Picture> pictures;
    for (const FrameOptions& options : scene.options)
        pictures.push_back(renderPicture(scene.scene, geometry, *tracer, options));
    return pictures;
}

std::vector<Picture> renderOn(Device& device, const hard::PictureScene& scene, const Geometry& geometry,
                              const Structure& structure) {
    const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, structure);
    DeviceFrame frame(device, scene.scene, geometry, *tracer);
    std::vector<Picture> pictures;
    for (FrameOptions options : scene.options) {
        if (scene.isDrawn && !pictures.empty()) options.itemsOf = &structure;
        pictures.push_back(frame.render(options));
    }
    return pictures;
}

Structure buildFor(const hard::PictureScene& scene, const Geometry& geometry, const Variant& variant) {
    return scene.keepsInstances
               ? buildTwoLevels(placedScene(geometry, {}), structureType(variant.structure), variant.params)
               : variant.build(primitivesOf(geometry));
}

}  // namespace

PictureSubject pictureSubjectOf(const Variant& variant, Device* device) {
    const auto render = [variant, device](const hard::PictureScene& scene) {
        const Geometry geometry = scene.keepsInstances ? gatherInstances(scene.scene) : flatten(scene.scene);
        Structure structure = buildFor(scene, geometry, variant);
        markSeeThrough(scene.scene, geometry, structure);
        if (device == nullptr) return renderOnCpu(scene, geometry, structure);
        if (scene.largestBinding == 0) return renderOn(*device, scene, geometry, structure);
        Device limited(device->info(), {.largestBindingElements = scene.largestBinding});
        return renderOn(limited, scene, geometry, structure);
    };
    return {variant.structure, describeOptions(variant.params) + (variant.params.nestsGrids ? " (nested)" : ""), render};
}

StressReport stressPictures(const PictureSettings& settings,
                            const std::function<void(const std::string&, double)>& progress) {
    StressReport report;
    for (size_t index = 0; index < settings.cases.size() && !report.stopped; ++index) {
        const hard::PictureCase& pictureCase = settings.cases[index];
        std::vector<StressResult> results;
        for (const PictureSubject& subject : settings.subjects)
            results.push_back({.number = pictureCase.number,
                               .structure = subject.structure,
                               .options = subject.options,
                               .device = settings.device,
                               .deviceNumber = settings.deviceNumber,
                               .isOfPixels = true,
                               .examples = {}});
        const std::vector<hard::PictureScene> scenes = pictureCase.make(settings.draw);
        for (size_t i = 0; i < scenes.size() && !report.stopped; ++i) {
            if (scenes[i].largestBinding > 0 && !settings.isDevice) continue;
            if (scenes[i].isDrawn && !settings.draws) continue;
            Rendered first;
            for (size_t s = 0; s < settings.subjects.size() && !report.stopped; ++s) {
                const PictureSubject& subject = settings.subjects[s];
                progress(
                    fmt::format("case {}", pictureCase.number),
                    (double(index) + (double(i) + double(s) / double(settings.subjects.size())) / double(scenes.size())) /
                        double(settings.cases.size()));
                Rendered rendered = renderAll(subject, scenes[i]);
                if (rendered.stopped)
                    report.stopped = Error(rendered.stopped->exitCode,
                                           fmt::format("case {}, {} on {}: {}", pictureCase.number, results[s].name(),
                                                       settings.device, rendered.stopped->what()));
                if (rendered.stopped && rendered.stopped->exitCode == ExitCode::limit) break;  // is no wrong answer
                Judging(results[s], scenes[i], rendered, s > 0 ? &first : nullptr).judge();
                if (s == 0) first = std::move(rendered);
            }
        }
        std::erase_if(results, [](const StressResult& result) { return result.rays == 0; });  // not reached, or not for it
        report.results.insert(report.results.end(), results.begin(), results.end());
    }
    return report;
}

TraceCorrupt corruptTraceOf(Device* device) {
    return [device](const Structure& structure, std::span<const Ray> rays, std::span<Hit> hits) {
        if (device != nullptr)
            makeDeviceTracer(*device, structure)->trace(rays, hits, Query::closest);
        else
            makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    };
}

StressReport stressCorruption(std::span<const Variant> variants, const TraceCorrupt& trace, const hard::Draw& draw,
                              const std::string& device, size_t deviceNumber) {
    const std::vector<Triangle> triangles = hard::sphere(12, 1.0, dvec3(0), 0.1);
    Random random = draw.random(100);
    std::vector<Ray> rays;
    while (rays.size() < 100) {
        const dvec3 from = 3.0 * random.direction();
        rays.push_back(
            {vec3(from), 0.0f, vec3(0.8 * dvec3(random.inCube(-1, 1)) - from), std::numeric_limits<float>::infinity()});
    }
    std::vector<Hit> hits(rays.size());
    StressReport report;
    for (const Variant& variant : variants) {
        Structure structure = variant.build(triangles);
        if (!leadAround(structure)) continue;
        StressResult result{.number = 62,
                            .structure = variant.structure,
                            .options = describeOptions(variant.params),
                            .device = device,
                            .deviceNumber = deviceNumber,
                            .rays = rays.size(),
                            .examples = {}};
        const auto fail = [&](StressFault fault, const std::string& what) {
            result.faulty = result.counts[static_cast<size_t>(fault)] = rays.size();
            result.examples = {{0, "links that lead around", fault, what}};
        };
        const auto start = std::chrono::steady_clock::now();
        try {
            trace(structure, rays, hits);
            fail(StressFault::wrong, "answered as if the structure were sound");
        } catch (const CorruptStructure&) {  // as it should be
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const Error& error) {
            fail(StressFault::error, error.what());
            if (endsRun(error)) report.stopped = error;
        } catch (const std::exception& other) {
            fail(StressFault::error, other.what());
        }
        result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (result.faulty == 0 && result.seconds > soon)
            fail(StressFault::hung, fmt::format("was told only after {:.0f} s", result.seconds));
        report.results.push_back(result);
        if (report.stopped) break;
    }
    return report;
}

}  // namespace raig

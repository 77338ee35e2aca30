// `raig compare`: a scene's hits and picture against the double-precision reference, or one picture against another.
#include "app/commands.hpp"
#include "app/compare_json.hpp"
#include "app/compare_options.hpp"
#include "app/compare_text.hpp"
#include "app/integrator_options.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "app/setup.hpp"
#include "app/view_options.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "base/log.hpp"
#include "rays/frame.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void writeDifference(const Options& options, const Image& test, const Image& expected) {
    if (options.output.empty()) return;
    const Image map = falseColour(flipValues(test, expected, {}, options.pixelsPerDegree), test.width, test.height);
    writePicture(options.output, map, {{"Software", "raig"}, {"Title", "FLIP, 0 (dark) to 1 (light); green: not finite"}});
}

/// What is known of a metric besides its value: the ray to look at.
using Details = std::vector<std::pair<std::string_view, std::string>>;

/// One text a bound; empty if it is kept.
std::vector<std::string> failuresOf(const std::vector<CheckedBound>& bounds, const Details& details) {
    std::vector<std::string> failures;
    for (const CheckedBound& one : bounds) {
        failures.push_back(one.failure());
        for (const auto& [metric, text] : details)
            if (!one.isKept() && metric == one.bound.metric->name) failures.back() += "; " + text;
    }
    return failures;
}

/// Tells the bounds in `document`, if that is wanted, in JUnit's XML, and line by line; and gives the exit code.
int conclude(const Options& options, const std::vector<CheckedBound>& bounds, const Details& details, Json document) {
    std::vector<std::string> failures = failuresOf(bounds, details);
    if (!options.junit.empty()) {
        const std::string xml = toJUnit(options.inputs[0].stem().string(), bounds, failures);
        writeFileAtomically(options.junit, std::as_bytes(std::span(xml)));
    }
    std::erase(failures, "");
    if (options.json) {
        document["bounds"] = toJson(bounds);
        document["fell_short"] = failures;
        std::puts(document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    }
    for (const std::string& line : failures) log::warn("fell short: {}", line);
    return static_cast<int>(failures.empty() ? ExitCode::done : ExitCode::fellShort);
}

int comparePictureFiles(const Options& options) {
    checkBoundsOfPictures(options);
    const Image test = readPicture(options.inputs[0]), expected = readPicture(options.inputs[1]);
    if (test.width != expected.width || test.height != expected.height)
        throw inputError(options.inputs[1].string(),
                         "is {} x {}, but {} is {} x {}; only pictures of one size can be compared", expected.width,
                         expected.height, options.inputs[0].string(), test.width, test.height);
    const PictureDifference difference = comparePictures(test, expected, {}, options.pixelsPerDegree);
    const std::vector<CheckedBound> bounds = checkBounds(options.bounds, difference);
    writeDifference(options, test, expected);
    if (difference.pixels == 0) log::warn("no pixel is finite in both pictures: there is nothing to compare");
    if (!options.json) printPictures(difference);
    return conclude(options, bounds, {}, {{"pixels", toJson(difference)}, {"pixels_per_degree", options.pixelsPerDegree}});
}

Image imageOf(const Picture& picture) {
    Image image;
    image.width = picture.width;
    image.height = picture.height;
    image.pixels = picture.radiance;
    return image;
}

Picture renderOnDevice(Setup& setup, const FrameOptions& frame) {
    Progress progress("device");
    return setup.device
               ? renderPicture(*setup.device, setup.scene, setup.geometry, *setup.deviceTracer, frame, progress.callback())
               : renderPicture(setup.scene, setup.geometry, *setup.tracer, frame, progress.callback());
}

reference::Picture renderReference(const reference::World& world, const FrameOptions& frame) {
    reference::PictureOptions options;
    options.width = frame.width;
    options.height = frame.height;
    options.samples = frame.samples;
    options.filter = frame.filter;
    options.camera = frame.camera;
    options.crop = frame.crop;
    options.aperture = frame.aperture;
    options.focus = frame.focus;
    options.bounds = {frame.maxDepth, frame.minContribution, frame.seed};
    options.integrator = frame.integrator;
    options.reach = frame.reach;
    Progress progress("reference");
    return reference::render(world, options, [&](double done) {
        progress.update(done, done * double(frame.part().pixels()) * options.samples * (1 + options.roundings));
    });
}

/// What goes before all that was found.
Json headOf(const Options& options, const Setup& setup, const FrameOptions& frame) {
    const Crop part = frame.part();
    return {{"scene", options.inputs[0].string()},
            {"device", setup.deviceName()},
            {"structure", {{"name", setup.structure.name}, {"walk", setup.structure.walk}}},
            {"triangles", setup.geometry.triangleCount()},
            {"spheres", setup.geometry.spheres.size()},
            {"width", frame.width},
            {"height", frame.height},
            {"crop", {{"x", part.x}, {"y", part.y}, {"width", part.width}, {"height", part.height}}},
            {"integrator", integratorNames[static_cast<size_t>(frame.integrator)]},
            {"samples", frame.samples},
            {"pixels_per_degree", options.pixelsPerDegree}};
}

/// Agreement about nothing must not look like agreement.
void warnIfVacuous(const SceneComparison& found) {
    if (found.pixels.blank)
        log::warn("every pixel of the reference has the same colour: that the pictures agree says nothing; try --camera");
    for (const RayFamily& family : found.families)
        if (family.hits.met == 0)
            log::warn("none of the {} {} rays hits anything: that they agree says little", family.hits.rays(), family.name);
}

/// The first ray that differs belongs to the metric that counts it.
Details detailsOf(const SceneComparison& found, const std::string& walker) {
    Details details;
    if (const auto first = firstDifference(found.families))
        details.emplace_back(hitClassNames[static_cast<uint32_t>(first->difference.kind)], describe(*first, walker));
    if (const auto first = firstBitDifference(found.families)) details.emplace_back("different", describe(*first, walker));
    return details;
}

void compareRays(Setup& setup, const reference::Tree& tree, const FrameOptions& frame, SceneComparison& found) {
    std::unique_ptr<Tracer> cpu;
    bool denormalsAreZero = false;
    if (setup.device) {
        cpu = makeCpuTracer(setup.structure);
        const MeasuredArithmetic measured = measureArithmetic(*setup.device);
        found.isIeee = measured.arithmetic && measured.arithmetic->ieee();
        denormalsAreZero = measured.arithmetic && measured.arithmetic->denormals != "kept";
    }
    found.families = compareFamilies(tree, cameraRays(setup.scene, frame), setup.scene.cameras[frame.camera].eye,
                                     *setup.tracer, cpu.get(), denormalsAreZero);
    found.all = sumOf(found.families);
    found.bits = sumOfBits(found.families);
}

int compareScene(const Options& options) {
    const std::unique_ptr<Setup> setup = prepare(options, options.inputs[0]);
    FrameOptions frame = frameOptions(options, setup->scene, /* defaultSamples= */ 1);
    setIntegrator(options, *setup, frame);

    SceneComparison found;
    Clock::time_point start = Clock::now();
    const Picture picture = renderOnDevice(*setup, frame);
    found.deviceSeconds = secondsSince(start);
    start = Clock::now();
    if (setup->geometry.isInstanced()) setup->geometry = flatten(setup->scene);  // as the reference knows it
    const reference::World world(setup->scene, setup->geometry);
    const reference::Picture expected = renderReference(world, frame);
    found.referenceSeconds = secondsSince(start);

    const Image image = imageOf(picture);
    found.pixels = compareToReference(image, expected, tieSensitivity, options.pixelsPerDegree);
    compareRays(*setup, world.tree, frame, found);
    for (const float discarded : picture.discarded) {
        found.discardedMean += discarded / static_cast<double>(picture.discarded.size());
        found.discardedMax = std::max(found.discardedMax, double{discarded});
    }
    writeDifference(options, image, roundedImage(expected));

    const std::vector<CheckedBound> bounds = checkBounds(sceneBounds(options.bounds, found), found);
    const std::string walker =
        fmt::format("{} ({}) on {}", setup->structure.name, setup->structure.walk, setup->deviceName());
    warnIfVacuous(found);
    if (!options.json) printScene(found, walker);
    Json document = headOf(options, *setup, frame);
    document.update(toJson(found));
    return conclude(options, bounds, detailsOf(found, walker), std::move(document));
}

}  // namespace

int compare(const Options& options) {
    return options.inputs.size() == 2 ? comparePictureFiles(options) : compareScene(options);
}

}  // namespace raig

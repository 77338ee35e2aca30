// `raig compare`: a scene's hits and picture against the double-precision reference, or one picture against another.
#include "measure/compare.hpp"
#include "app/commands.hpp"
#include "app/progress.hpp"
#include "app/setup.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "measure/compare_rays.hpp"
#include "rays/frame.hpp"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// The largest root mean square difference, outside ties, that a picture may have.
constexpr double rmseBound = 1e-3;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void print(const Json& document) {
    std::puts(document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

Json toJson(const PictureDifference& d) {
    return {{"rmse", d.rmse},        {"relmse", d.relmse},    {"psnr", d.psnr}, {"ssim", d.ssim}, {"flip_mean", d.flipMean},
            {"flip_p99", d.flipP99}, {"flip_max", d.flipMax}, {"max", d.max},   {"nan", d.nan},   {"compared", d.pixels}};
}

Json toJson(const Spread& spread) {
    return {{"median", spread.median}, {"p99", spread.p99}, {"max", spread.max}};
}

void printRow(const char* name, const PictureDifference& d) {
    fmt::print("{:14} {:>8}  {:.3e}  {:.3e}  {:.3e}  {:6.2f}  {:.5f}  {:.5f}  {:.5f}  {:>5}\n", name, d.pixels, d.max,
               d.rmse, d.relmse, d.psnr, d.ssim, d.flipMean, d.flipP99, d.nan);
}

void printPixelHeader() {
    fmt::print("{:14} {:>8}  {:>9}  {:>9}  {:>9}  {:>6}  {:>7}  {:>7}  {:>7}  {:>5}\n", "pixels", "compared", "max", "rmse",
               "relmse", "psnr", "ssim", "flip", "flip99", "nan");
}

void writeDifference(const Options& options, const Image& test, const Image& expected) {
    if (options.output.empty()) return;
    const Image map = falseColour(flipValues(test, expected), test.width, test.height);
    writePicture(options.output, map, {{"Software", "raig"}, {"Title", "FLIP, 0 (dark) to 1 (light); green: not finite"}});
}

int comparePictureFiles(const Options& options) {
    const Image test = readPicture(options.inputs[0]), expected = readPicture(options.inputs[1]);
    if (test.width != expected.width || test.height != expected.height)
        throw inputError(options.inputs[1].string(),
                         "is {} x {}, but {} is {} x {}; only pictures of one size can be compared", expected.width,
                         expected.height, options.inputs[0].string(), test.width, test.height);
    const PictureDifference difference = comparePictures(test, expected);
    writeDifference(options, test, expected);
    if (options.json) {
        print({{"pixels", toJson(difference)}});
    } else {
        printPixelHeader();
        printRow("all", difference);
    }
    return static_cast<int>(ExitCode::done);
}

/// The hits of one family of rays.
struct Family {
    const char* name;
    HitComparison comparison;
};

/// All that is said of a scene.
struct Findings {
    std::vector<Family> families;
    HitComparison all;  ///< faults: of the first family that has any
    PictureComparison pixels;
    Spread discarded;  ///< only max is used
    double discardedMean = 0.0;
    double deviceSeconds = 0.0;
    double referenceSeconds = 0.0;
};

std::vector<Family> compareFamilies(Setup& setup, const reference::Tree& tree, const FrameOptions& frame) {
    const std::vector<Ray> camera = cameraRays(setup.scene, frame);
    const vec3 eye = setup.scene.cameras[frame.camera].eye;
    std::vector<Family> families;
    const auto compareFamily = [&](const char* name, const std::vector<Ray>& rays) {
        std::vector<Hit> hits(rays.size());
        if (!rays.empty()) setup.tracer->trace(rays, hits, Query::closest);
        families.push_back({name, compareHits(tree, rays, hits)});
    };
    compareFamily("camera", camera);
    compareFamily("bounce", bounceRays(tree, camera));
    compareFamily("aimed", aimedRays(setup.geometry, eye, camera.size()));
    return families;
}

/// Adds up the counts. The distances of t are those of the family where they are largest.
HitComparison sum(const std::vector<Family>& families) {
    HitComparison all;
    for (const auto& [name, comparison] : families) {
        all.met += comparison.met;
        all.offset.median = std::max(all.offset.median, comparison.offset.median);
        all.offset.p99 = std::max(all.offset.p99, comparison.offset.p99);
        all.offset.max = std::max(all.offset.max, comparison.offset.max);
        for (size_t i = 0; i < all.counts.size(); ++i) all.counts[i] += comparison.counts[i];
        all.tUlp.median = std::max(all.tUlp.median, comparison.tUlp.median);
        all.tUlp.p99 = std::max(all.tUlp.p99, comparison.tUlp.p99);
        all.tUlp.max = std::max(all.tUlp.max, comparison.tUlp.max);
        if (all.faults.empty()) all.faults = comparison.faults;
    }
    return all;
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
    options.camera = frame.camera;
    options.bounds = {frame.maxDepth, frame.minContribution, frame.seed};
    Progress progress("reference");
    return reference::render(world, options, [&](double done) {
        progress.update(done, done * options.width * options.height * options.samples * (1 + options.roundings));
    });
}

Json toJson(const HitComparison& c) {
    Json counts;
    for (size_t i = 0; i < c.counts.size(); ++i) counts[std::string(hitClassNames[i])] = c.counts[i];
    return counts;
}

Json toJson(const Options& options, const Setup& setup, const FrameOptions& frame, const Findings& found,
            const std::vector<std::string>& shortfalls) {
    Json families;
    for (const auto& [name, comparison] : found.families)
        families[name] = {{"rays", comparison.rays()},
                          {"met", comparison.met},
                          {"hits", toJson(comparison)},
                          {"t_ulp", toJson(comparison.tUlp)},
                          {"offset", toJson(comparison.offset)}};
    Json pixels = toJson(found.pixels.outsideTies);
    pixels["ties"] = found.pixels.ties;
    pixels["blank"] = found.pixels.blank;
    pixels["with_ties"] = toJson(found.pixels.everywhere);
    return {{"scene", options.inputs[0].string()},
            {"device", setup.deviceName()},
            {"structure", {{"name", setup.structure.name}, {"walk", setup.structure.walk}}},
            {"triangles", setup.geometry.triangleCount()},
            {"spheres", setup.geometry.spheres.size()},
            {"width", frame.width},
            {"height", frame.height},
            {"samples", frame.samples},
            {"hits", toJson(found.all)},
            {"t_ulp", toJson(found.all.tUlp)},
            {"offset", toJson(found.all.offset)},
            {"families", families},
            {"pixels", pixels},
            {"discarded_weight", {{"mean", found.discardedMean}, {"max", found.discarded.max}}},
            {"device_s", found.deviceSeconds},
            {"reference_s", found.referenceSeconds},
            {"fell_short", shortfalls}};
}

void printTable(const Findings& found) {
    fmt::print("{:8} {:>8} {:>8}  {:>8} {:>8} {:>6} {:>7} {:>6}  {:>7}  {}\n", "rays", "traced", "hit", "same", "tie",
               "missed", "phantom", "wrong", "offset", "t in ULP: median, 99 %, max");
    for (const auto& [name, c] : found.families)
        fmt::print("{:8} {:>8} {:>8}  {:>8} {:>8} {:>6} {:>7} {:>6}  {:>7.3f}  {}, {}, {}\n", name, c.rays(), c.met,
                   c.counts[0], c.counts[1], c.counts[2], c.counts[3], c.counts[4], c.offset.max, c.tUlp.median, c.tUlp.p99,
                   c.tUlp.max);
    printPixelHeader();
    printRow("outside ties", found.pixels.outsideTies);
    printRow("with ties", found.pixels.everywhere);
    fmt::print("{} pixels are ties: rounding their rays as floats are moves them by more than {}\n", found.pixels.ties,
               tieSensitivity);
    fmt::print("discarded weight: {:.3e} on average, {:.3e} at most\n", found.discardedMean, found.discarded.max);
    fmt::print("device {:.2f} s, reference {:.2f} s\n", found.deviceSeconds, found.referenceSeconds);
}

/// One line for each bound that is not kept.
std::vector<std::string> listShortfalls(const Findings& found) {
    std::vector<std::string> lines;
    const HitComparison& all = found.all;
    if (all.faultCount() > 0)
        lines.push_back(fmt::format("{} rays missed, {} phantom, {} wrong; allowed: 0", all.count(HitClass::missed),
                                    all.count(HitClass::phantom), all.count(HitClass::wrong)));
    if (!(all.offset.max <= 1.0))
        lines.push_back(fmt::format("a hit lies {:.3f} tolerances off its triangle; allowed: 1", all.offset.max));
    if (found.pixels.everywhere.nan > 0)
        lines.push_back(fmt::format("{} pixels are not finite; allowed: 0", found.pixels.everywhere.nan));
    if (!(found.pixels.outsideTies.rmse <= rmseBound))
        lines.push_back(fmt::format("rmse outside ties is {:.3e}; allowed: {}", found.pixels.outsideTies.rmse, rmseBound));
    return lines;
}

/// Agreement about nothing must not look like agreement.
void warnIfVacuous(const Findings& found) {
    if (found.pixels.blank)
        log::warn("every pixel of the reference has the same colour: that the pictures agree says nothing; try --camera");
    for (const auto& [name, comparison] : found.families)
        if (comparison.met == 0)
            log::warn("none of the {} {} rays hits anything: that they agree says little", comparison.rays(), name);
}

void noteFaults(const HitComparison& all) {
    for (const HitComparison::Difference& fault : all.faults)
        log::note("ray {}: {}: the reference has triangle {} at {}, the device {} at {}", fault.ray,
                  hitClassNames[static_cast<uint32_t>(fault.kind)], static_cast<int32_t>(fault.oracle.primitive),
                  fault.oracle.t, static_cast<int32_t>(fault.device.primitive), fault.device.t);
}

int compareScene(const Options& options) {
    const std::unique_ptr<Setup> setup = prepare(options, options.inputs[0]);
    FrameOptions frame;
    frame.width = options.width;
    frame.height = options.height;
    frame.samples = options.samples ? options.samples : 1;
    frame.maxDepth = options.maxDepth;
    frame.minContribution = static_cast<float>(options.minContribution);
    frame.seed = options.seed;
    frame.camera = chooseCamera(setup->scene, options.camera);

    Findings found;
    Clock::time_point start = Clock::now();
    const Picture picture = renderOnDevice(*setup, frame);
    found.deviceSeconds = secondsSince(start);
    start = Clock::now();
    if (setup->geometry.isInstanced()) setup->geometry = flatten(setup->scene);  // as the reference knows it
    const reference::World world(setup->scene, setup->geometry);
    const reference::Picture expected = renderReference(world, frame);
    found.referenceSeconds = secondsSince(start);

    const Image image = imageOf(picture);
    found.pixels = compareToReference(image, expected);
    found.families = compareFamilies(*setup, world.tree, frame);
    found.all = sum(found.families);
    for (const float discarded : picture.discarded) {
        found.discardedMean += discarded / static_cast<double>(picture.discarded.size());
        found.discarded.max = std::max(found.discarded.max, double{discarded});
    }
    writeDifference(options, image, roundedImage(expected));

    const std::vector<std::string> shortfalls = listShortfalls(found);
    noteFaults(found.all);
    warnIfVacuous(found);
    if (options.json)
        print(toJson(options, *setup, frame, found, shortfalls));
    else
        printTable(found);
    for (const std::string& line : shortfalls) log::warn("fell short: {}", line);
    return static_cast<int>(shortfalls.empty() ? ExitCode::done : ExitCode::fellShort);
}

}  // namespace

int compare(const Options& options) {
    return options.inputs.size() == 2 ? comparePictureFiles(options) : compareScene(options);
}

}  // namespace raig

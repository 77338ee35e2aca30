#include "app/sampling_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"
#include "rays/adaptive.hpp"
#include "scene/import.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>

namespace raig {

namespace {

constexpr uint32_t usualMost = 1024;
constexpr double usualTolerance = 0.03;  // where few samples leave noise ...
constexpr uint32_t usualMostOfThose = 64;
constexpr uint32_t mostSamples = 65536;
constexpr double shareForFiles = 0.04;  // of the time, to write the picture

constexpr std::array<std::string_view, 3> filterNames = {"box", "tent", "gauss"};  // as Filter has them

bool leavesNoise(const Options& options, const Scene& scene) {
    return options.integrator != Integrator::whitted || options.aperture > 0.0f || scene.environment || emitsLight(scene);
}

}  // namespace

const char* const samplingHelp =
    "--adaptive: each pixel gets 8 samples, and twice as many again and again while its error is estimated to be above\n"
    "the tolerance, up to --spp (default: 1024). Errors are root mean squares in linear light, whatever the exposure; the\n"
    "picture's is about the tolerance. --view samples shows where samples went.\n"
    "Without --spp, --adaptive and --time: 4 samples a pixel; where light is soft (lamps with a size, an environment,\n"
    "other integrators than whitted) or a lens blurs, as by --adaptive 0.03 --spp 64.\n"
    "--time: the best picture within so many seconds, from the start on: with as many samples as go into it, up to\n"
    "--spp (default: 65536), and those where they are needed if --adaptive is given. How many depends on the machine; the\n"
    "file and --json say it, and --spp with that number gives the same picture, to the last bit. One sample a pixel is\n"
    "taken, however long that lasts; with --frames it is the time of each picture.\n";

std::string_view nameOf(Filter filter) {
    return filterNames[static_cast<size_t>(filter)];
}

void addFilterOption(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        const auto found = std::ranges::find(filterNames, text);
        if (found == filterNames.end()) throw usageError("--filter {}: box, tent or gauss is wanted", text);
        options.filter = static_cast<Filter>(found - filterNames.begin());
    };
    command
        .add_option_function<std::string>("--filter", parse,
                                          "how a pixel weighs what is around its middle: box, tent or gauss (default: box)")
        ->type_name("NAME");
}

void addSamplingOptions(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        const std::optional<double> tolerance = numberOf<double>(text);
        if (!tolerance || !(*tolerance > 0.0 && *tolerance < INFINITY))
            throw usageError("--adaptive {}: an error above 0 is wanted, in linear light, as 0.01", text);
        options.tolerance = *tolerance;
    };
    command
        .add_option_function<std::string>("--adaptive", parse,
                                          "samples where they are needed, until the error of pixels is below this")
        ->type_name("TOLERANCE");
    const auto parseTime = [&options](const std::string& text) {
        const std::optional<double> seconds = numberOf<double>(text);
        if (!seconds || !(*seconds > 0.0 && *seconds <= 1e6))
            throw usageError("--time {}: seconds above 0 are wanted, up to a million", text);
        options.seconds = *seconds;
    };
    command
        .add_option_function<std::string>("--time", parseTime, "the best picture within so many seconds, up to --spp")
        ->type_name("SECONDS");
}

void checkSamplingOptions(const Options& options) {
    if (options.tolerance > 0.0 && options.samples > 0 && options.samples < firstSamples)
        throw usageError("--spp {}: with --adaptive, which begins with {} samples a pixel, it is the most: {} or more",
                         options.samples, firstSamples, firstSamples);
}

void setSampling(const Options& options, const Scene& scene, std::chrono::steady_clock::time_point start,
                 FrameOptions& frame) {
    const std::chrono::duration<double> time(options.seconds.value_or(0.0) * (1.0 - shareForFiles));
    if (options.seconds) frame.deadline = start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(time);
    frame.tolerance = options.tolerance;
    if (options.samples > 0) return;
    if (options.seconds) {
        frame.samples = mostSamples;
    } else if (options.tolerance > 0.0) {
        frame.samples = usualMost;
    } else if (leavesNoise(options, scene)) {
        frame.samples = usualMostOfThose;
        frame.tolerance = usualTolerance;
    }
}

SampleCounts countSamples(const FrameOptions& frame, const Picture& picture) {
    const std::vector<uint32_t>& samples = picture.samples;
    if (samples.empty()) return {frame.samples, frame.samples, double(frame.samples)};
    SampleCounts counts{samples.front(), samples.front(), 0.0};
    for (const uint32_t count : samples) {
        counts.least = std::min(counts.least, count);
        counts.most = std::max(counts.most, count);
        counts.mean += count;
    }
    counts.mean /= double(samples.size());
    return counts;
}

std::string samplingText(const FrameOptions& frame, const Picture& picture) {
    const SampleCounts counts = countSamples(frame, picture);
    if (counts.least == counts.most && frame.tolerance == 0.0)
        return fmt::format("{} a pixel, seed {}", counts.most, frame.seed);
    return fmt::format("{} to {} a pixel, {:.2f} on average, seed {}; tolerance {}, at most {}", counts.least, counts.most,
                       counts.mean, frame.seed, frame.tolerance, frame.samples);
}

void addSampling(const FrameOptions& frame, const Picture& picture, nlohmann::ordered_json& document) {
    const SampleCounts counts = countSamples(frame, picture);
    document["samples_a_pixel"] = {{"min", counts.least}, {"mean", counts.mean}, {"max", counts.most}};
    if (frame.tolerance == 0.0) return;
    document["tolerance"] = frame.tolerance;
    document["unsettled_pixels"] = picture.statistics.unsettled;
}

}  // namespace raig

/// How a picture is sampled: the options of `raig render`, what becomes of them, and what is told of it.
#pragma once

#include "app/options.hpp"
#include "rays/frame.hpp"

#include <nlohmann/json.hpp>

namespace CLI {
class App;
}

namespace raig {

/// Adds --adaptive and --time. They throw usageError for what is no tolerance, or no time.
void addSamplingOptions(CLI::App& command, Options& options);

/// Adds --filter. It throws usageError for what is none.
void addFilterOption(CLI::App& command, Options& options);

/// As --filter has it.
std::string_view nameOf(Filter filter);

/// The lines of --help that tell what these options do to each other.
extern const char* const samplingHelp;

/// Throws usageError for fewer samples than errors can be estimated from.
void checkSamplingOptions(const Options& options);

/// Samples a pixel where nothing else is said.
constexpr uint32_t usualSamples = 4;

/// Puts what is asked for into `frame`, whose samples are --spp or usualSamples. Time counts from `start` on. Where nothing
/// is asked for, and so few samples would leave noise (soft light, a lens), there are more, where they are needed.
void setSampling(const Options& options, const Scene& scene, std::chrono::steady_clock::time_point start,
                 FrameOptions& frame);

/// How many samples the pixels of a picture have.
struct SampleCounts {
    uint32_t least = 0;
    uint32_t most = 0;
    double mean = 0.0;
};
SampleCounts countSamples(const FrameOptions& frame, const Picture& picture);

/// The same in words.
std::string samplingText(const FrameOptions& frame, const Picture& picture);

/// Adds it to what --json prints.
void addSampling(const FrameOptions& frame, const Picture& picture, nlohmann::ordered_json& document);

}  // namespace raig

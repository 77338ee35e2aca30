#include "app/animation_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"

#include <CLI/CLI.hpp>

#include <cmath>

namespace raig {

namespace {

constexpr uint32_t mostFrames = 999'999;

}  // namespace

const char* const animationHelp =
    "--time-at SECONDS shows a .gltf or .glb that moves at a moment of one of its animations (the first, unless\n"
    "--animation names another); before its start and after its end all is as it is then. Without, all is at rest.\n";

void addMomentOptions(CLI::App& command, Options& options) {
    const auto parseTime = [&options](const std::string& text) {
        const std::optional<double> seconds = numberOf<double>(text);
        if (!seconds || !std::isfinite(*seconds)) throw usageError("--time-at {}: a number of seconds is wanted", text);
        options.moment.seconds = *seconds;
    };
    command
        .add_option_function<std::string>("--time-at", parseTime,
                                          "the moment of an animation that is shown (default: all is at rest)")
        ->type_name("SECONDS");
    command
        .add_option("--animation", options.moment.animation,
                    "which of the file's animations, by name or index (default: the first)")
        ->type_name("ANIMATION");
}

void addFrameOptions(CLI::App& command, Options& options) {
    const auto parseFrames = [&options](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = numberOf<uint32_t>(std::string_view(text).substr(0, colon));
        std::optional<uint32_t> last;
        if (colon != text.npos) last = numberOf<uint32_t>(std::string_view(text).substr(colon + 1));
        if (!first || !last || *first > *last || *last > mostFrames)
            throw usageError("--frames {}: FIRST:LAST is wanted, whole numbers from 0 to {} in order", text, mostFrames);
        options.frames = FrameRange{*first, *last};
    };
    CLI::Option* const frames = command.add_option_function<std::string>(
        "--frames", parseFrames, "a picture of each of these frames, both included: out.0000.png and so on");
    frames->type_name("FIRST:LAST");
    const auto parseRate = [&options](const std::string& text) {
        const std::optional<double> rate = numberOf<double>(text);
        if (!rate || !(*rate >= 1e-3 && *rate <= 1e6))
            throw usageError("--fps {}: a number from 0.001 to 1000000 is wanted", text);
        options.framesPerSecond = *rate;
    };
    command.add_option_function<std::string>("--fps", parseRate, "frames a second: frame N is at N / FPS (default: 24)")
        ->type_name("FPS")
        ->needs(frames);
}

void checkAnimationOptions(const Options& options) {
    if (!options.moment.animation.empty() && !options.moment.seconds && !options.frames)
        throw usageError("--animation {}: at which moment? Give --time-at{} too", options.moment.animation,
                         options.command == Command::render ? " or --frames" : "");
    if (!options.frames) return;
    if (options.moment.seconds) throw usageError("--frames: leave --time-at out: each frame has a time of its own");
    if (!options.saveStructure.empty() || !options.loadStructure.empty())
        throw usageError("--frames: leave --save-structure and --load-structure out: each frame has a structure of its own");
}

double secondsOf(const Options& options, uint32_t frame) {
    return frame / options.framesPerSecond;
}

std::filesystem::path fileOf(const std::filesystem::path& output, uint32_t frame) {
    std::filesystem::path file = output;
    return file.replace_extension(fmt::format("{:04}{}", frame, output.extension().string()));
}

}  // namespace raig

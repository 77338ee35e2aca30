#include "app/tone_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"
#include "base/log.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <cmath>

namespace raig {

const char* const toneHelp =
    "--exposure is for all files, and light in .hdr, .exr and .pfm stays linear; --tonemap is for .png only. With\n"
    "--exposure auto the mean logarithm of the light of what is rendered becomes that of 0.18. Where it is not given, a\n"
    ".png in which hardly anything could be told apart, as it is 2.5 stops too dark or more, or 4 too bright, gets that.\n";

void addToneOptions(CLI::App& command, Options& options) {
    const auto parseExposure = [&options](const std::string& text) {
        const std::optional<double> stops = numberOf<double>(text);
        if (text != "auto" && !(stops && std::abs(*stops) <= 100.0))
            throw usageError("--exposure {}: stops from -100 to 100 are wanted, or auto", text);
        options.exposure = text == "auto" ? Exposure::suitable : Exposure::stops;
        options.stops = stops.value_or(0.0);
    };
    command
        .add_option_function<std::string>(
            "--exposure", parseExposure,
            "light times 2^STOPS, or auto: middle grey on average (default: 0, where that can be seen)")
        ->type_name("STOPS");
    const auto parseTone = [&options](const std::string& text) {
        const std::optional<Tone> tone = findTone(text);
        if (!tone) throw usageError("--tonemap {}: one of {} is wanted", text, fmt::join(toneNames(), ", "));
        options.tone = *tone;
    };
    command
        .add_option_function<std::string>("--tonemap", parseTone,
                                          fmt::format("how bright light is shown in a .png: {} (default: none, clamped)",
                                                      fmt::join(toneNames(), ", ")))
        ->type_name("CURVE");
}

namespace {

/// True if the picture is for eyes, and may be exposed so that they see something.
bool isLegible(const Options& options) {
    return options.exposure == Exposure::legible && pictureFormat(options.output) == PictureFormat::png;
}

}  // namespace

void checkToneOptions(const Options& options) {
    if (options.tone != Tone::none && !options.output.empty() && pictureFormat(options.output) != PictureFormat::png)
        throw usageError("--tonemap: {} keeps light as it is; write a .png, or leave --tonemap out",
                         options.output.string());
}

double showLight(const Options& options, Image& image) {
    constexpr double tooDark = 2.5, tooBright = -4.0;
    double stops = options.stops;
    if (options.exposure == Exposure::suitable || isLegible(options)) {
        const std::optional<double> suitable = suitableStops(image);
        const bool isAsked = options.exposure == Exposure::suitable;
        const bool isNeeded = suitable && (*suitable >= tooDark || *suitable <= tooBright);
        if (!suitable) log::warn("{}: the picture is black: no light comes from what is seen", options.output.string());
        stops = suitable && (isAsked || isNeeded) ? *suitable : 0.0;
        if (isAsked && suitable) log::note("exposure: {:+.2f} stops", stops);
        if (!isAsked && isNeeded)
            log::note("exposure: {:+.2f} stops, as little could be seen without; --exposure 0 shows light as it is", stops);
    }
    expose(image, stops);
    bend(image, options.tone);
    return stops;
}

}  // namespace raig

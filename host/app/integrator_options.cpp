#include "app/integrator_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>

namespace raig {

const char* const integratorHelp =
    "--integrator: whitted follows mirrored and transmitted rays, with direct and ambient light. path follows light all\n"
    "its ways, from each point one, by chance: indirect light, rough reflections and what glass focuses, in the place of\n"
    "ambient light. Rays that weigh less than 256 times --min-contribution end by chance, without a bias. ao shows ambient\n"
    "occlusion: white where nothing is near above a surface, whatever its material. Near is what is within --ao-distance,\n"
    "in the scene's units, or inf (default: a quarter of the picture's height, where most is seen). More samples make all\n"
    "smoother.\n";

void addIntegratorOptions(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        const auto named = std::ranges::find(integratorNames, text);
        if (named == integratorNames.end())
            throw usageError("--integrator {}: one of {} is wanted", text, fmt::join(integratorNames, ", "));
        options.integrator = static_cast<Integrator>(named - integratorNames.begin());
    };
    command
        .add_option_function<std::string>(
            "--integrator", parse,
            fmt::format("how light is followed: {} (default: whitted)", fmt::join(integratorNames, ", ")))
        ->type_name("NAME");
    const auto parseDistance = [&options](const std::string& text) {
        const std::optional<float> distance = numberOf<float>(text);
        if (!distance || !(*distance > 0.0f))
            throw usageError("--ao-distance {}: a distance above 0 is wanted, in the scene's units, or inf", text);
        options.aoDistance = *distance;
    };
    command
        .add_option_function<std::string>("--ao-distance", parseDistance,
                                          "how far ambient occlusion looks (default: as suits the scene)")
        ->type_name("DISTANCE");
}

void checkIntegratorOptions(const Options& options) {
    if (options.aoDistance && options.integrator != Integrator::ao)
        throw usageError("--ao-distance {}: is for --integrator ao", *options.aoDistance);
}

void setIntegrator(const Options& options, Setup& setup, FrameOptions& frame) {
    frame.integrator = options.integrator;
    if (options.integrator != Integrator::ao) return;
    frame.reach = options.aoDistance ? *options.aoDistance : suitableReach(setup.scene, *setup.tracer, frame);
}

std::string integratorText(const FrameOptions& frame) {
    if (frame.integrator == Integrator::ao) return fmt::format("ambient occlusion up to {}", frame.reach);
    return std::string(integratorNames[static_cast<size_t>(frame.integrator)]);
}

}  // namespace raig

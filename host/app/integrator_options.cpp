#include "app/integrator_options.hpp"

#include "base/error.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
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
        double distance = 0.0;
        const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), distance);
        const bool isNumber = fault == std::errc{} && end == text.data() + text.size();
        const auto rounded = static_cast<float>(distance);
        if (!isNumber || !(rounded > 0.0f))
            throw usageError("--ao-distance {}: a distance above 0 is wanted, in the scene's units, or inf", text);
        options.aoDistance = rounded;
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

namespace {

/// A quarter of the picture's height at the median distance of what is seen.
float usualReach(Setup& setup, FrameOptions frame) {
    frame.crop.reset();
    frame.aperture = 0.0f;
    frame.samples = 1;
    frame.width = frame.height = 32;
    const std::vector<Ray> rays = cameraRays(setup.scene, frame);
    std::vector<Hit> hits(rays.size());
    setup.tracer->trace(rays, hits, Query::closest);
    std::erase_if(hits, [](const Hit& hit) { return hit.primitive == NO_HIT; });
    if (hits.empty()) return INFINITY;
    const auto middle = hits.begin() + static_cast<std::ptrdiff_t>(hits.size() / 2);
    std::nth_element(hits.begin(), middle, hits.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
    const Camera& camera = setup.scene.cameras[frame.camera];
    const double height = camera.orthographic ? 2.0 * camera.ymag : 2.0 * std::tan(0.5 * camera.yfov) * middle->t;
    return static_cast<float>(0.25 * height);
}

}  // namespace

void setIntegrator(const Options& options, Setup& setup, FrameOptions& frame) {
    frame.integrator = options.integrator;
    if (options.integrator != Integrator::ao) return;
    const float reach = options.aoDistance ? *options.aoDistance : usualReach(setup, frame);
    frame.reach = reach > 0.0f ? reach : INFINITY;
}

std::string integratorText(const FrameOptions& frame) {
    if (frame.integrator == Integrator::ao) return fmt::format("ambient occlusion up to {}", frame.reach);
    return std::string(integratorNames[static_cast<size_t>(frame.integrator)]);
}

}  // namespace raig

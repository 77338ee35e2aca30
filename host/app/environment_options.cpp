#include "app/environment_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "image/image.hpp"
#include "scene/import.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raig {

namespace {

double numberFrom(const char* option, const std::string& text, double least, double most) {
    const std::optional<double> value = numberOf<double>(text);
    if (!value || !(*value >= least && *value <= most))
        throw usageError("{} {}: a number from {:g} to {:g} is wanted", option, text, least, most);
    return *value;
}

}  // namespace

const char* const environmentHelp =
    "--environment takes a picture of all directions, equirectangular: its top is +Y, its middle -Z, the right of that\n"
    "+X. It is seen instead of a sky, and lights what is there instead of a headlight and of ambient light.\n";

void addEnvironmentOptions(CLI::App& command, Options& options) {
    CLI::Option* const picture = command.add_option(
        "--environment", options.environment, "light from all directions: an equirectangular .hdr, .exr, .pfm or .png");
    picture->type_name("FILE");
    const auto parseScale = [&options](const std::string& text) {
        options.environmentScale = numberFrom("--environment-scale", text, 0.0, 1e6);
    };
    command
        .add_option_function<std::string>("--environment-scale", parseScale, "what its light is multiplied by (default: 1)")
        ->type_name("X")
        ->needs(picture);
    const auto parseTurn = [&options](const std::string& text) {
        options.environmentTurn = numberFrom("--environment-rotate", text, -360.0, 360.0) * std::numbers::pi / 180.0;
    };
    command
        .add_option_function<std::string>("--environment-rotate", parseTurn,
                                          "how far it is turned, counterclockwise from above (default: 0)")
        ->type_name("DEGREES")
        ->needs(picture);
}

void setEnvironment(const Options& options, Scene& scene) {
    if (options.environment.empty()) return;
    Image image = readPicture(options.environment);
    size_t bad = 0;
    for (vec3& pixel : image.pixels) {
        const bool isLight = isFinite(pixel) && pixel.x >= 0.0f && pixel.y >= 0.0f && pixel.z >= 0.0f;
        if (isLight) continue;
        pixel = vec3(0.0f);
        ++bad;
    }
    if (bad > 0)
        scene.remarks.push_back(
            fmt::format("environment: {} of its pixels are negative or not finite, and are taken for black", bad));
    if (image.width != 2 * image.height)
        scene.remarks.push_back(fmt::format("environment: is {} x {}, not twice as wide as high, and stretched to be",
                                            image.width, image.height));
    lightByEnvironment(scene, fromEquirectangular(image.pixels, image.width, image.height, options.environmentScale,
                                                  options.environmentTurn));
    log::note("environment: {} x {} pixels, kept as {} x {} of an octahedron's", image.width, image.height,
              scene.environment->side, scene.environment->side);
    if (!scene.environment->shines()) log::warn("environment: {} is black", options.environment.string());
}

}  // namespace raig

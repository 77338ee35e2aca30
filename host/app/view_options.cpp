#include "app/view_options.hpp"

#include "app/setup.hpp"
#include "base/error.hpp"
#include "base/triangle.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace raig {

namespace {

/// The numbers of "1,2.5,-3"; nothing unless there are N of them.
template <class Number, size_t N>
std::optional<std::array<Number, N>> numbersOf(std::string_view text) {
    std::array<Number, N> values{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (size_t i = 0; i < N; ++i) {
        const auto [next, fault] = std::from_chars(at, end, values[i]);
        if (fault != std::errc{} || (i + 1 < N ? next == end || *next != ',' : next != end)) return std::nullopt;
        at = next + 1;
    }
    return values;
}

void addSize(CLI::App& command, Options& options, uint32_t side) {
    const auto parse = [&options](const std::string& text) {
        std::string numbers = text;
        std::replace(numbers.begin(), numbers.end(), 'x', ',');
        const auto size = text.find(',') == text.npos ? numbersOf<uint32_t, 2>(numbers) : std::nullopt;
        const auto isSide = [](uint32_t pixels) { return pixels >= 1 && pixels <= 65536; };
        if (!size || !isSide((*size)[0]) || !isSide((*size)[1]))
            throw usageError("--size {}: WIDTHxHEIGHT is wanted, each from 1 to 65536", text);
        options.width = (*size)[0];
        options.height = (*size)[1];
        options.sizeIsGiven = true;
    };
    command.preparse_callback([&options, side](size_t) { options.width = options.height = side; });
    command
        .add_option_function<std::string>(
            "--size", parse,
            fmt::format("of the picture (default: {0}x{0}, or as many pixels in the shape that the camera asks for)", side))
        ->type_name("WxH");
}

void addVector(CLI::App& command, const std::string& name, std::optional<vec3>& value, const std::string& description) {
    const auto parse = [&value, name](const std::string& text) {
        const auto numbers = numbersOf<double, 3>(text);
        const vec3 v = numbers ? vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]) : vec3(0.0f);
        if (!numbers || !isInRange(v))
            throw usageError("{} {}: X,Y,Z is wanted, three numbers from -1.8e18 to 1.8e18", name, text);
        value = v;
    };
    command.add_option_function<std::string>(name, parse, description)->type_name("X,Y,Z");
}

void addFov(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        const auto degrees = numbersOf<double, 1>(text);
        const auto angle = static_cast<float>(degrees ? (*degrees)[0] * std::numbers::pi / 180.0 : 0.0);
        // The float nearest to pi is more than pi.
        if (!(angle > 0.0f && angle < static_cast<float>(std::numbers::pi)))
            throw usageError("--fov {}: degrees between 0 and 180 are wanted", text);
        options.viewChange.yfov = angle;
    };
    command.add_option_function<std::string>("--fov", parse, "angle that the camera sees, from bottom to top")
        ->type_name("DEGREES");
}

void addCrop(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        const auto numbers = numbersOf<uint32_t, 4>(text);
        if (!numbers || (*numbers)[2] == 0 || (*numbers)[3] == 0)
            throw usageError("--crop {}: X,Y,WIDTH,HEIGHT is wanted: whole numbers, a width and height of at least 1", text);
        options.crop = Crop{(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
    };
    command
        .add_option_function<std::string>("--crop", parse,
                                          "only this part of the picture, in pixels from its top left; they are the whole's")
        ->type_name("X,Y,W,H");
}

void addLens(CLI::App& command, Options& options) {
    const auto parseAperture = [&options](const std::string& text) {
        const auto numbers = numbersOf<double, 1>(text);
        if (!numbers || !((*numbers)[0] >= 0.0 && (*numbers)[0] <= largestCoordinate))
            throw usageError("--aperture {}: the lens's diameter is wanted, in the scene's units, from 0 on", text);
        options.aperture = static_cast<float>((*numbers)[0]);
    };
    command
        .add_option_function<std::string>("--aperture", parseAperture,
                                          "diameter of the lens, in the scene's units (default: 0, all is sharp)")
        ->type_name("DIAMETER");
    const auto parseFocus = [&options](const std::string& text) {
        const auto numbers = numbersOf<double, 1>(text);
        const float distance = numbers ? static_cast<float>((*numbers)[0]) : 0.0f;
        if (!(distance > 0.0f))
            throw usageError("--focus {}: a distance above 0 is wanted, in the scene's units, or inf", text);
        options.focus = distance;
    };
    command
        .add_option_function<std::string>("--focus", parseFocus,
                                          "distance at which the picture is sharp, along the camera's axis (default: that "
                                          "of the point that the camera looks at)")
        ->type_name("DISTANCE");
}

/// Where the picture is sharp.
float focusOf(const Options& options, const Camera& camera) {
    if (options.focus) return *options.focus;
    const double distance = camera.target ? glm::distance(dvec3(*camera.target), dvec3(camera.eye)) : 0.0;
    if (!(distance > 0.0))
        throw usageError("--aperture {}: give --focus too, or --at: the camera {} looks at no point in particular",
                         options.aperture, camera.name.empty() ? "(unnamed)" : camera.name);
    return static_cast<float>(distance);
}

/// Throws usageError for a part that is not in the picture.
void checkCrop(const std::optional<Crop>& crop, uint32_t width, uint32_t height) {
    if (crop && !crop->liesIn(width, height))
        throw usageError("--crop {},{},{},{}: is not in the picture, which has {} x {} pixels", crop->x, crop->y,
                         crop->width, crop->height, width, height);
}

/// Gives the frame as many pixels as it has, nearly, in the shape that the camera asks for, if it does.
void takeShape(const Camera& camera, FrameOptions& frame) {
    if (!(camera.aspect > 0.0f)) return;
    const double stretch = std::sqrt(double{camera.aspect});
    const auto pixels = [](double side) { return static_cast<uint32_t>(std::clamp(std::round(side), 1.0, 65536.0)); };
    frame.width = pixels(frame.width * stretch);
    frame.height = pixels(frame.height / stretch);
}

}  // namespace

const char* const viewHelp =
    "--eye, --at, --up and --fov change the camera that --camera names, each only what it says. With --eye alone, a\n"
    "camera of the file keeps its direction, and raig's own view the point in its middle. A camera that is turned has\n"
    "+Y up, unless --up is given; --up alone tilts it.\n";

void addViewOptions(CLI::App& command, Options& options, uint32_t side) {
    addSize(command, options, side);
    command.add_option("--camera", options.camera, "a camera of the file, by name or index (default: the first)")
        ->type_name("CAMERA");
    addVector(command, "--eye", options.viewChange.eye, "where the camera stands");
    addVector(command, "--at", options.viewChange.at, "the point that it looks at");
    addVector(command, "--up", options.viewChange.up,
              "the direction that is up in the picture (default: 0,1,0 if it is turned)");
    addFov(command, options);
    addCrop(command, options);
    addLens(command, options);
}

void checkViewOptions(const Options& options) {
    if (options.sizeIsGiven) checkCrop(options.crop, options.width, options.height);
    if (options.focus && options.aperture == 0.0f)
        throw usageError("--focus {}: without a lens all is sharp; give its diameter by --aperture", *options.focus);
    // With these two given, no direction of the scene's camera matters.
    if (options.viewChange.eye && options.viewChange.at)
        changedView(Camera{}, {options.viewChange.eye, options.viewChange.at, options.viewChange.up, std::nullopt});
}

FrameOptions frameOptions(const Options& options, Scene& scene, uint32_t defaultSamples) {
    FrameOptions frame;
    frame.width = options.width;
    frame.height = options.height;
    frame.crop = options.crop;
    frame.samples = options.samples ? options.samples : defaultSamples;
    frame.filter = options.filter;
    frame.maxDepth = options.maxDepth;
    frame.minContribution = static_cast<float>(options.minContribution);
    frame.seed = options.seed;
    frame.camera = chooseCamera(scene, options.camera);
    Camera& camera = scene.cameras[frame.camera];
    camera = changedView(camera, options.viewChange);
    turnHeadlights(scene, camera);
    if (!options.sizeIsGiven) takeShape(camera, frame);
    checkCrop(frame.crop, frame.width, frame.height);
    if (options.aperture > 0.0f) {
        frame.aperture = options.aperture;
        frame.focus = focusOf(options, camera);
        if (frame.aperture > 1e6 * frame.focus)
            throw usageError("--aperture {}: is more than a million times the distance in focus, {}", frame.aperture,
                             frame.focus);
    }
    return frame;
}

}  // namespace raig

#include "support/chart_documents.hpp"

#include "image/image.hpp"
#include "image/metrics.hpp"

#include <fmt/format.h>

#include <cmath>

namespace raig::test {

namespace {

const std::vector<std::string> scenes = {"cornell_spheres.glb", hostileName};

/// A ball before a wall. With `spots`, some pixels of it are as a method that misses hits shows them.
Image ball(const vec3& colour, bool hasSpots) {
    Image image(360, 270);
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x) {
            const vec2 at((float(x) + 0.5f - 180.0f) / 110.0f, (135.0f - float(y) - 0.5f) / 110.0f);
            const float inside = 1.0f - at.x * at.x - at.y * at.y;
            vec3 pixel = vec3(0.18f, 0.2f, 0.24f) * (1.0f + 0.5f * at.y);
            if (inside > 0.0f) {
                const vec3 normal(at.x, at.y, std::sqrt(inside));
                pixel = colour * (0.08f + 0.9f * std::max(0.0f, glm::dot(normal, vec3(-0.48f, 0.6f, 0.64f))));
            }
            if (hasSpots && (x * 7919u + y * 104729u) % 97u == 0 && inside > 0.0f) pixel = vec3(0.0f);
            image.at(x, y) = pixel;
        }
    return image;
}

ChartPictures picturesOf(const std::string& scene, const vec3& colour, bool isBad) {
    const Image device = ball(colour, isBad), reference = ball(colour, false);
    const Image difference = falseColour(flipValues(device, reference), device.width, device.height);
    const auto png = [](const Image& image) { return encodePicture(image, PictureFormat::png); };
    return {scene,
            device.width,
            device.height,
            png(device),
            png(reference),
            png(difference),
            {{"rmse", 0.0123456},
             {"flip_mean", isBad ? 0.0031 : 0.0},
             {"flip_p99", isBad ? 0.0872 : 0.0},
             {"nan", isBad ? 3 : 0},
             {"missed", isBad ? 391 : 0},
             {"phantom", 0},
             {"wrong", 0},
             {"device_s", 0.8154},
             {"reference_s", 12.25}}};
}

/// Dots on axes, with "light" or "dark" as the id of its root.
std::string drawn(const std::string& title, bool isDark, int seed) {
    const char* ink = isDark ? "#e4e7ea" : "#1c2024";
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" id=\"{}\" width=\"600\" height=\"440\" viewBox=\"0 0 600 440\">"
        "<rect width=\"600\" height=\"440\" fill=\"{}\"/><g fill=\"{}\" font-family=\"sans-serif\" font-size=\"15\">"
        "<text x=\"300\" y=\"28\" text-anchor=\"middle\">{}</text>"
        "<text x=\"320\" y=\"428\" "
        "text-anchor=\"middle\">milliseconds</text>"
        "<text transform=\"translate(22 220) rotate(-90)\" text-anchor=\"middle\">missed + phantom per million</text></g>",
        isDark ? "dark" : "light", isDark ? "#16191c" : "#ffffff", ink, title);
    for (int i = 0; i <= 4; ++i)
        svg += fmt::format(
            "<path d=\"M80 {0}H580\" stroke=\"{1}\" stroke-opacity=\"0.15\"/><text x=\"72\" y=\"{2}\" text-anchor=\"end\" "
            "font-family=\"sans-serif\" font-size=\"15\" fill=\"{1}\">10{3}</text>",
            50 + i * 80, ink, 55 + i * 80, std::vector<const char*>{"⁴", "²", "⁰", "⁻²", "⁻⁴"}[static_cast<size_t>(i)]);
    const std::vector<const char*> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7"};
    for (int i = 0; i < 24; ++i)
        svg += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"5\" fill=\"{}\" stroke=\"{}\" stroke-width=\"2\"/>",
                           100 + (i * 83 + seed * 31) % 470, 60 + (i * 57 + seed * 17) % 300,
                           i % 5 == 0 ? "none" : colours[size_t(i) % 4], colours[size_t(i) % 4]);
    return svg + "</svg>";
}

ChartPanel panelOf(const std::string& title, const std::string& stem, int seed) {
    return {title, stem, drawn(title, false, seed), drawn(title, true, seed),
            "Dots: what " + title + " costs, and how often it errs"};
}

ChartFigure methods() {
    ChartFigure figure;
    figure.sweep.name = "methods";
    figure.sweep.title = "Methods: what they cost, and what they miss";
    figure.sweep.text =
        "Each dot is one way to find the first hit; below and to the left is better. The textbook variants are drawn "
        "hollow: they "
        "fail a hard case somewhere, whatever they do here.";
    figure.sweep.measures = {"milliseconds", "missed", "phantom", "wrong", "bytes"};
    figure.sweep.laws.resize(2);
    figure.sweep.laws[0].because = "a structure changes the cost, never the answer";
    figure.sweep.laws[1].because = "any-hit queries agree with closest-hit ones";
    const std::vector<std::string> labels = {"brute force", "BVH 2",        "BVH 4",           "BVH 8",
                                             "grid",        "octree",       "kd-tree",         "BSP",
                                             "Embree",      "min/max slab", "Möller–Trumbore", "accumulated DDA"};
    for (const std::string& scene : scenes)
        for (size_t i = 0; i < labels.size(); ++i) {
            const bool isNaive = i >= 9;
            ChartPoint point{scene, {{"label", labels[i]}, {"precision", "f32"}, {"offset", 0}}, {}, ""};
            point.measures = {{"milliseconds", 3.0 + 517.0 / double(i + 1)},
                              {"missed", isNaive ? 12.5 * double(i) : 0.0},
                              {"phantom", i == 11 ? 3.0 : 0.0},
                              {"wrong", i == 8 ? Json() : Json(0)},
                              {"bytes", 1234567 * (i + 1)}};
            figure.points.push_back(point);
        }
    figure.panels = {panelOf("Cornell spheres", "methods-cornell", 1), panelOf("The other scene", "methods-other", 2)};
    return figure;
}

ChartFigure density() {
    ChartFigure figure;
    figure.sweep.name = "grid-density";
    figure.sweep.title = "Uniform grids: cells for each triangle";
    figure.sweep.text = "Too few cells, and each holds too much; too many, and a ray crosses them one by one.";
    figure.sweep.measures = {"milliseconds", "fetches", "differing"};
    figure.sweep.laws.resize(1);
    figure.sweep.laws[0].because = "a structure changes the cost, never the answer";
    for (const std::string& scene : scenes)
        for (int levels = 1; levels <= 2; ++levels)
            for (int step = 0; step < 20; ++step) {
                const double cells = 0.5 * std::exp2(0.25 * step);
                ChartPoint point{scene, {{"accel", "grid"}, {"levels", levels}, {"grid-density", cells}}, {}, ""};
                if (levels == 2 && step > 17)
                    point.leftOut = "the structure needs 3.2 GiB, and 2 GiB are allowed";
                else
                    point.measures = {{"milliseconds", 4.0 + std::abs(cells - 3.7) * 1.37},
                                      {"fetches", 21.0 + 3.3e-5 * step},
                                      {"differing", 0}};
                figure.points.push_back(point);
            }
    figure.panels = {panelOf("One level", "grid-density-1", 3), panelOf("Two levels", "grid-density-2", 4)};
    return figure;
}

ChartFigure samples() {
    ChartFigure figure;
    figure.sweep.name = "samples";
    figure.sweep.title = "Samples a pixel, and the error that is left";
    figure.sweep.text =
        "A Monte Carlo estimate errs by the square root of its samples: on logarithmic axes a line of slope −1/2.";
    figure.sweep.measures = {"rmse", "seconds", "flip_p99"};
    figure.sweep.laws.resize(1);
    figure.sweep.missing = {{"area lights", "lights are points and directions so far"},
                            {"a finer integrator", "paths of diffuse bounces are not followed"}};
    for (int power = 0; power < 16; ++power)
        figure.points.push_back(
            {scenes[0],
             {{"spp", 1 << power}},
             {{"rmse", 0.1 * std::exp2(-0.4 * power)}, {"seconds", 0.01 * std::exp2(power)}, {"flip_p99", Json()}},
             ""});
    figure.panels = {panelOf("Error over samples", "samples", 5)};
    figure.breaches = {{"samples", scenes[0], "rmse falls with spp by a slope of -0.4000, not between -0.55 and -0.45"},
                       {"samples", scenes[1], "rmse is 0.2 where its bound is 0.1"}};
    return figure;
}

}  // namespace

ChartDocument chartDocument() {
    ChartDocument document;
    document.version = "0.1.0";
    document.commit = "0123456789abcdef0123456789abcdef01234567";
    document.processor = "A processor with <angles> & an ampersand";
    document.device = "llvmpipe (LLVM 15.0.6, 256 bits)";
    document.driver = "a driver of the year 19\xff\xfe, Mesa 22.3.6";
    document.arithmetic = "as IEEE 754; denormals kept; a * b + c fused: no, where precise: no; fma unfused";
    document.flags = "-O3 -ffp-contract=off -fno-fast-math";
    document.command = "raig chart cornell_spheres.glb --seed 7 -o charts";
    document.threads = 2;
    document.seed = 7;
    document.seconds = 512.3456;
    document.pictures = {picturesOf(scenes[0], vec3(0.8f, 0.3f, 0.2f), true),
                         picturesOf(scenes[1], vec3(0.2f, 0.5f, 0.7f), false)};
    document.figures = {methods(), density(), samples()};
    return document;
}

}  // namespace raig::test

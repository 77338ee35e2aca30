#include "image/tone.hpp"

#include "base/parallel.hpp"
#include "image/srgb.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace raig {

namespace {

constexpr std::array<std::string_view, 5> names = {"none", "reinhard", "filmic", "aces", "neutral"};

double reinhard(double x) { return x / (1.0 + x); }

double filmic(double x) {
    const auto curve = [](double v) {
        constexpr double a = 0.15, b = 0.50, c = 0.10, d = 0.20, e = 0.02, f = 0.30;
        return (v * (a * v + c * b) + d * e) / (v * (a * v + b) + d * f) - e / f;
    };
    constexpr double bias = 2.0, white = 11.2;
    return curve(bias * x) / curve(white);
}

double aces(double x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); }

dvec3 neutral(const dvec3& light) {
    constexpr double start = 0.8 - 0.04, room = 1.0 - start, desaturation = 0.15;
    const double least = std::min({light.x, light.y, light.z});
    const dvec3 color = light - (least < 0.08 ? least - 6.25 * least * least : 0.04);
    const double peak = std::max({color.x, color.y, color.z});
    if (peak < start) return color;
    const double newPeak = 1.0 - room * room / (peak + room - start);
    const double white = 1.0 - 1.0 / (desaturation * (peak - newPeak) + 1.0);
    return glm::mix(color * (newPeak / peak), dvec3(newPeak), white);
}

dvec3 bent(const dvec3& light, Tone tone) {
    const auto each = [&](double (*curve)(double)) { return dvec3(curve(light.x), curve(light.y), curve(light.z)); };
    switch (tone) {
        case Tone::none: return light;
        case Tone::reinhard: return each(reinhard);
        case Tone::filmic: return each(filmic);
        case Tone::aces: return each(aces);
        case Tone::neutral: return neutral(light);
    }
    return light;
}

bool isNan(const vec3& c) { return std::isnan(c.x) || std::isnan(c.y) || std::isnan(c.z); }

double luminance(const vec3& c) { return srgb::redWeight * c.x + srgb::greenWeight * c.y + srgb::blueWeight * c.z; }

}  // namespace

std::optional<Tone> findTone(std::string_view name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return static_cast<Tone>(found - names.begin());
}

std::string_view nameOf(Tone tone) { return names[static_cast<size_t>(tone)]; }

std::vector<std::string_view> toneNames() { return {names.begin(), names.end()}; }

void expose(Image& image, double stops) {
    if (stops == 0.0) return;
    const double factor = std::exp2(stops);
    parallelFor(image.pixels.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) image.pixels[i] = vec3(factor * dvec3(image.pixels[i]));
    });
}

void bend(Image& image, Tone tone) {
    if (tone == Tone::none) return;
    parallelFor(image.pixels.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            vec3& c = image.pixels[i];
            if (isNan(c)) continue;
            const dvec3 light = glm::clamp(dvec3(c), 0.0, double{std::numeric_limits<float>::max()});
            c = vec3(glm::clamp(bent(light, tone), 0.0, 1.0));
        }
    });
}

std::optional<double> suitableStops(const Image& image) {
    double sum = 0.0;
    uint64_t count = 0;
    const auto forEach = [&](const auto& take) {
        for (const vec3& c : image.pixels)
            if (const double light = luminance(c); light > 0.0 && std::isfinite(light)) take(light);
    };
    forEach([&](double light) { sum += light, ++count; });
    if (count == 0) return std::nullopt;
    const double floor = sum / double(count) / 1024.0;
    double logarithms = 0.0;
    forEach([&](double light) { logarithms += std::log2(std::max(light, floor)); });
    constexpr double key = 0.18;
    return std::log2(key) - logarithms / double(count);
}

}  // namespace raig

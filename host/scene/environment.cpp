#include "scene/environment.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace raig {

namespace {

double weightOf(const vec3& radiance, uint32_t side, uint32_t column, uint32_t row) {
    const double u = (2.0 * column + 1.0) / side - 1.0, v = (2.0 * row + 1.0) / side - 1.0;
    const double y = 1.0 - std::abs(u) - std::abs(v);
    const double x = y < 0.0 ? 1.0 - std::abs(v) : u, z = y < 0.0 ? 1.0 - std::abs(u) : v;
    const double squared = x * x + y * y + z * z;
    return (0.2126 * radiance.x + 0.7152 * radiance.y + 0.0722 * radiance.z) / (squared * std::sqrt(squared));
}

/// Their shares of `whole`, cumulated: rounded down, but to no less than 1 where there is a weight; the largest makes up for
/// it, the first of equal ones. All 0 if no weight is positive.
void cumulate(std::span<const double> weights, std::span<uint32_t> cumulated) {
    double sum = 0.0;
    for (const double weight : weights) sum += weight;
    std::ranges::fill(cumulated, 0);
    if (!(sum > 0.0)) return;
    int64_t rest = Environment::whole;
    for (size_t i = 0; i < weights.size(); ++i) {
        if (!(weights[i] > 0.0)) continue;
        cumulated[i] = std::max(1u, static_cast<uint32_t>(weights[i] / sum * Environment::whole));
        rest -= cumulated[i];
    }
    const auto largest = std::ranges::max_element(weights) - weights.begin();
    cumulated[largest] = static_cast<uint32_t>(cumulated[largest] + rest);
    for (size_t i = 1; i < cumulated.size(); ++i) cumulated[i] += cumulated[i - 1];
}

/// Sums what falls on each texel.
class Unfolded {
public:
    explicit Unfolded(uint32_t side) : side_(side), light_(size_t{side} * side, dvec3(0.0)), angle_(light_.size(), 0.0) {}

    void add(const dvec3& d, const dvec3& radiance, double solidAngle) {
        const double sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
        double u = d.x / sum, v = d.z / sum;
        if (d.y < 0.0) {
            const double beyond = std::copysign(1.0 - std::abs(v), u);
            v = std::copysign(1.0 - std::abs(u), v);
            u = beyond;
        }
        const size_t texel = size_t{placeOf(v)} * side_ + placeOf(u);
        light_[texel] += solidAngle * radiance;
        angle_[texel] += solidAngle;
    }
    std::vector<vec3> texels() const {
        std::vector<vec3> mean(light_.size(), vec3(0.0f));
        for (size_t i = 0; i < mean.size(); ++i)
            if (angle_[i] > 0.0)
                mean[i] = vec3(glm::min(light_[i] / angle_[i], dvec3(std::numeric_limits<float>::max())));
        return mean;
    }

private:
    uint32_t placeOf(double x) const {
        return std::min(static_cast<uint32_t>(0.5 * (x + 1.0) * side_), side_ - 1);
    }

    uint32_t side_;
    std::vector<dvec3> light_;
    std::vector<double> angle_;
};

}  // namespace

Environment makeEnvironment(uint32_t side, std::vector<vec3> texels) {
    RAIG_CHECK(side >= 2 && side <= 4096 && side % 2 == 0);
    RAIG_CHECK_OP(texels.size(), ==, size_t{side} * side);
    Environment environment{side, std::move(texels), {}, std::vector<uint32_t>(side)};
    environment.columns.resize(environment.texels.size());
    std::vector<double> weights(side), ofRows(side, 0.0);
    for (uint32_t row = 0; row < side; ++row) {
        for (uint32_t column = 0; column < side; ++column) {
            weights[column] = weightOf(environment.texels[size_t{row} * side + column], side, column, row);
            ofRows[row] += weights[column];
        }
        cumulate(weights, std::span(environment.columns).subspan(size_t{row} * side, side));
    }
    cumulate(ofRows, environment.rows);
    return environment;
}

Environment fromEquirectangular(std::span<const vec3> pixels, uint32_t width, uint32_t height, double scale, double turn) {
    RAIG_CHECK_OP(pixels.size(), ==, size_t{width} * height);
    constexpr double pi = std::numbers::pi;
    const double wanted = std::clamp(std::sqrt(double(width) * height), 128.0, 2048.0);
    const uint32_t side = 2 * static_cast<uint32_t>(std::ceil(0.5 * wanted));
    // Each pixel is cut into parts of a quarter of the narrowest texel, which is 2 / side wide.
    const auto across = static_cast<uint32_t>(std::ceil(4.0 * pi * side / width));
    const auto down = static_cast<uint32_t>(std::ceil(2.0 * pi * side / height));
    std::vector<dvec2> around(size_t{width} * across);  // sine and cosine
    for (size_t i = 0; i < around.size(); ++i) {
        const double angle = 2.0 * pi * ((double(i) + 0.5) / double(around.size()) - 0.5) - turn;
        around[i] = {std::sin(angle), std::cos(angle)};
    }
    Unfolded unfolded(side);
    const size_t strips = size_t{height} * down;
    for (size_t strip = 0; strip < strips; ++strip) {
        const double from = pi * double(strip) / double(strips), to = pi * double(strip + 1) / double(strips);
        const double sine = std::sin(0.5 * (from + to)), cosine = std::cos(0.5 * (from + to));
        const double solidAngle = (std::cos(from) - std::cos(to)) * 2.0 * pi / double(around.size());
        for (size_t i = 0; i < around.size(); ++i) {
            const vec3& radiance = pixels[strip / down * width + i / across];
            unfolded.add({sine * around[i].x, cosine, -sine * around[i].y}, scale * dvec3(radiance), solidAngle);
        }
    }
    return makeEnvironment(side, unfolded.texels());
}

}  // namespace raig

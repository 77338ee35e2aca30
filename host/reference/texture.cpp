#include "reference/texture.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace raig::reference {

namespace {

double fromSrgb(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double toSrgb(double light) {
    return light <= 0.04045 / 12.92 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}

uint8_t toByte(double value) {
    return static_cast<uint8_t>(std::clamp(std::floor(255.0 * value + (0.5 + 1e-6)), 0.0, 255.0));
}

/// Texel `index` of `count`, carried back into the image.
uint32_t wrapped(double index, uint32_t count, Wrap wrap) {
    const double size = count;
    if (wrap == Wrap::clamp) return static_cast<uint32_t>(std::clamp(index, 0.0, size - 1.0));
    const double period = wrap == Wrap::mirror ? 2.0 * size : size;
    double place = index - std::floor(index / period) * period;
    if (place >= period) place = 0.0;  // index / period rounded
    return static_cast<uint32_t>(place < size ? place : 2.0 * size - 1.0 - place);
}

}  // namespace

Pyramids::Pyramids(const Scene& scene) : scene_(&scene) {
    for (int byte = 0; byte < 256; ++byte) linear_[byte] = fromSrgb(byte / 255.0);
    const auto make = [&](const std::optional<Texture>& texture, bool isSrgb) {
        if (!texture) return;
        Levels& levels = pyramids_[{texture->image, isSrgb}];
        if (!levels.empty()) return;
        const Texels& image = scene.images[texture->image];
        levels.push_back({image.width, image.height, image.rgba});
        while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(half(levels.back(), isSrgb));
    };
    for (const Material& material : scene.materials) {
        make(material.baseColorTexture, true);
        make(material.emissionTexture, true);
        make(material.roughnessTexture, false);
        make(material.normalTexture, false);
        make(material.occlusionTexture, false);
    }
}

dvec4 Pyramids::decoded(const uint8_t* texel, bool isSrgb) const {
    const dvec4 plain = dvec4(texel[0], texel[1], texel[2], texel[3]) / 255.0;
    return isSrgb ? dvec4(linear_[texel[0]], linear_[texel[1]], linear_[texel[2]], plain.w) : plain;
}

/// Each new texel gathers from the texels that its rectangle overlaps.
Pyramids::Level Pyramids::half(const Level& level, bool isSrgb) const {
    Level result{std::max(1u, level.width / 2), std::max(1u, level.height / 2), {}};
    result.rgba.resize(size_t{4} * result.width * result.height);
    const dvec2 size(double(level.width) / result.width, double(level.height) / result.height);
    parallelFor(result.height, 16, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row)
            for (size_t column = 0; column < result.width; ++column) {
                const dvec2 from = dvec2(column, row) * size, to = from + size;
                dvec4 sum(0.0);
                double area = 0.0;
                for (double y = std::floor(from.y); y < to.y && y < level.height; ++y)
                    for (double x = std::floor(from.x); x < to.x && x < level.width; ++x) {
                        const double wide = std::min(x + 1.0, to.x) - std::max(x, from.x);
                        const double share = wide * (std::min(y + 1.0, to.y) - std::max(y, from.y));
                        sum += share * decoded(&level.rgba[4 * (size_t(y) * level.width + size_t(x))], isSrgb);
                        area += share;
                    }
                sum /= area;
                uint8_t* texel = &result.rgba[4 * (row * result.width + column)];
                for (int k = 0; k < 4; ++k) texel[k] = toByte(isSrgb && k < 3 ? toSrgb(sum[k]) : sum[k]);
            }
    });
    return result;
}

dvec4 Pyramids::bilinear(const Level& level, const Texture& texture, bool isSrgb, const dvec2& uv) const {
    const dvec2 place = uv * dvec2(level.width, level.height) - 0.5;
    const dvec2 corner = glm::floor(place);
    const dvec2 fraction = place - corner;
    dvec4 value(0.0);
    for (int i = 0; i < 4; ++i) {
        const int right = i & 1, below = i >> 1;
        const size_t x = wrapped(corner.x + right, level.width, texture.wrapU);
        const size_t y = wrapped(corner.y + below, level.height, texture.wrapV);
        const double weight = (right ? fraction.x : 1.0 - fraction.x) * (below ? fraction.y : 1.0 - fraction.y);
        value += weight * decoded(&level.rgba[4 * (y * level.width + x)], isSrgb);
    }
    return value;
}

dvec4 Pyramids::lookUp(const Texture& texture, bool isSrgb, const dvec2& uv, double width) const {
    const auto found = pyramids_.find({texture.image, isSrgb});
    RAIG_CHECK(found != pyramids_.end());
    const Levels& levels = found->second;
    const dvec3 u(texture.u), v(texture.v), at(uv, 1.0);
    const dvec2 place(glm::dot(u, at), glm::dot(v, at));
    const double area = std::abs(u.x * v.y - u.y * v.x) * levels[0].width * levels[0].height;
    const double x = width * std::sqrt(area);
    if (!(x > 1.0)) return bilinear(levels[0], texture, isSrgb, place);
    const auto last = static_cast<int>(levels.size()) - 1;
    const int e = std::isfinite(x) ? std::ilogb(x) : last;
    const dvec4 fine = bilinear(levels[std::min(e, last)], texture, isSrgb, place);
    if (e >= last) return fine;
    return glm::mix(fine, bilinear(levels[e + 1], texture, isSrgb, place), std::ldexp(x, -e) - 1.0);
}

dvec3 Pyramids::mean(uint32_t image) const {
    const std::vector<uint8_t>& rgba = scene_->images[image].rgba;
    dvec3 sum(0.0);
    for (size_t i = 0; i < rgba.size(); i += 4) sum += dvec3(linear_[rgba[i]], linear_[rgba[i + 1]], linear_[rgba[i + 2]]);
    return sum / (double(rgba.size()) / 4.0);
}

}  // namespace raig::reference

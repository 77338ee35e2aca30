#include "app/aov_layers.hpp"

#include "base/box.hpp"
#include "base/error.hpp"

#include <bit>
#include <cmath>
#include <functional>

namespace raig {

namespace {

uint32_t bitsOf(float x) {
    return std::bit_cast<uint32_t>(x);
}
float floatOf(uint32_t bits) {
    return std::bit_cast<float>(bits);
}

/// Appends the words of pixel i.
void append(Aov aov, const AovSources& sources, size_t i, std::vector<uint32_t>& words) {
    const auto put = [&](const vec3& v) { words.insert(words.end(), {bitsOf(v.x), bitsOf(v.y), bitsOf(v.z)}); };
    const auto hit = [&]() -> const PrimaryHit& { return sources.hits.pixels[i]; };
    switch (aov) {
        case Aov::depth:
            return words.push_back(bitsOf(hit().depth));
        case Aov::position:
            return put(hit().position);
        case Aov::normal:
            return put(hit().normal);
        case Aov::uv:
            words.insert(words.end(), {bitsOf(hit().u), bitsOf(hit().v)});
            return;
        case Aov::primitive:
            return words.push_back(hit().primitive);
        case Aov::instance:
            return words.push_back(hit().instance);
        case Aov::material:
            return words.push_back(hit().material);
        case Aov::albedo:
            return put(hit().albedo);
        case Aov::samples:
            return words.push_back(sources.picture.samples.empty() ? sources.samples : sources.picture.samples[i]);
        case Aov::level:
            return words.push_back(sources.picture.levels[i]);
        case Aov::weight:
            return words.push_back(bitsOf(sources.picture.discarded[i]));
        case Aov::cost:
            return words.push_back(sources.picture.costs[i]);
    }
}

/// The power of two after which the colours of positions, or coordinates, come again: 8 to 16 times along the longest side
/// of what is seen, and for texture coordinates 1.
double periodOf(Aov aov, const PrimaryHits& hits) {
    if (aov != Aov::position) return 1.0;
    Box box;
    for (const PrimaryHit& hit : hits.pixels)
        if (hit.material != shared::NO_HIT) box.grow(hit.position);
    const dvec3 sides = dvec3(box.hi) - dvec3(box.lo);
    const double longest = std::max({sides.x, sides.y, sides.z});
    return longest > 0.0 && std::isfinite(longest) ? std::exp2(std::ceil(std::log2(longest / 16.0))) : 1.0;
}

vec3 colourOf(Aov aov, const uint32_t* words, bool isNothing, double period) {
    if (isNothing) return vec3(0.0f);
    const auto fractionOf = [&](float x) {
        const double periods = x / period;
        return std::isfinite(periods) ? static_cast<float>(periods - std::floor(periods)) : 0.0f;
    };
    const auto vector = [&] { return vec3(floatOf(words[0]), floatOf(words[1]), floatOf(words[2])); };
    switch (aov) {
        case Aov::normal:
            return shownAs(0.5f + 0.5f * vector());
        case Aov::albedo:
            return vector();
        case Aov::position:
            return shownAs({fractionOf(vector().x), fractionOf(vector().y), fractionOf(vector().z)});
        case Aov::uv:
            return shownAs({fractionOf(floatOf(words[0])), fractionOf(floatOf(words[1])), 0.0f});
        default:
            return colourOfId(words[0]);
    }
}

bool isNumber(Aov aov) {
    return aov == Aov::depth || aov == Aov::samples || aov == Aov::level || aov == Aov::weight || aov == Aov::cost;
}

}  // namespace

Layer layerOf(Aov aov, const AovSources& sources) {
    const AovType& type = typeOf(aov);
    const size_t pixels = size_t{sources.width} * sources.height;
    if (!type.isOfPicture) RAIG_CHECK_OP(sources.hits.pixels.size(), ==, pixels);
    if (aov == Aov::level) RAIG_CHECK_OP(sources.picture.levels.size(), ==, pixels);
    if (aov == Aov::weight) RAIG_CHECK_OP(sources.picture.discarded.size(), ==, pixels);
    if (aov == Aov::cost) RAIG_CHECK_OP(sources.picture.costs.size(), ==, pixels);
    Layer layer{std::string(type.name), type.channels, type.isWhole, {}};
    layer.words.reserve(pixels * type.channels.size());
    for (size_t i = 0; i < pixels; ++i) append(aov, sources, i, layer.words);
    return layer;
}

AovView viewOf(Aov aov, const AovSources& sources) {
    const Layer layer = layerOf(aov, sources);
    const size_t pixels = size_t{sources.width} * sources.height, stride = layer.channels.size();
    if (isNumber(aov)) {
        std::vector<double> values(pixels);
        for (size_t i = 0; i < pixels; ++i) values[i] = layer.isWhole ? layer.words[i] : double{floatOf(layer.words[i])};
        NumberView view = viewNumbers(values, sources.width, sources.height);
        return {std::move(view.image), std::pair(view.low, view.high)};
    }
    AovView view{Image(sources.width, sources.height), std::nullopt};
    const double period = periodOf(aov, sources.hits);
    for (size_t i = 0; i < pixels; ++i)
        view.image.pixels[i] =
            colourOf(aov, &layer.words[i * stride], sources.hits.pixels[i].material == shared::NO_HIT, period);
    return view;
}

}  // namespace raig

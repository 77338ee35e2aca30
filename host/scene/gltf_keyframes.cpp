#include "scene/gltf_keyframes.hpp"

#include <algorithm>
#include <cmath>

namespace raig::gltf {

namespace {

/// The keyframes around a moment, which may be the same one, and how far it is from the first to the second.
struct Between {
    size_t before = 0, after = 0;
    double share = 0.0;
    double seconds = 0.0;  ///< from the one to the other
};

Between findBetween(std::span<const float> times, double seconds) {
    const auto later = std::upper_bound(times.begin(), times.end(), seconds);
    if (later == times.begin()) return {};
    const auto before = static_cast<size_t>(later - times.begin()) - 1;
    if (later == times.end()) return {before, before};
    const double start = times[before], length = double(*later) - start;
    return {before, before + 1, (seconds - start) / length, length};
}

/// Number `k` of part `part` of a keyframe: 1 is the value of a spline, whose tangents are 0 and 2.
double numberOf(const Keyframes& keyframes, size_t keyframe, size_t part, size_t k) {
    const bool isSpline = keyframes.interpolation == Interpolation::cubicSpline;
    return keyframes.values[(isSpline ? keyframe * 3 + part : keyframe) * keyframes.width + k];
}

constexpr size_t inTangent = 0, itself = 1, outTangent = 2;

double splineAt(const Keyframes& keyframes, const Between& at, size_t k) {
    const double s = at.share, ss = s * s, sss = ss * s;
    return (2.0 * sss - 3.0 * ss + 1.0) * numberOf(keyframes, at.before, itself, k) +
           at.seconds * (sss - 2.0 * ss + s) * numberOf(keyframes, at.before, outTangent, k) +
           (3.0 * ss - 2.0 * sss) * numberOf(keyframes, at.after, itself, k) +
           at.seconds * (sss - ss) * numberOf(keyframes, at.after, inTangent, k);
}

double between(const Keyframes& keyframes, const Between& at, size_t k) {
    const double before = numberOf(keyframes, at.before, itself, k);
    if (at.before == at.after || keyframes.interpolation == Interpolation::step) return before;
    if (keyframes.interpolation == Interpolation::cubicSpline) return splineAt(keyframes, at, k);
    return (1.0 - at.share) * before + at.share * numberOf(keyframes, at.after, itself, k);
}

dvec4 unit(const dvec4& q) {
    return q / std::sqrt(glm::dot(q, q));
}

dvec4 rotationOf(const Keyframes& keyframes, size_t keyframe) {
    dvec4 q;
    for (int k = 0; k < 4; ++k) q[k] = numberOf(keyframes, keyframe, itself, k);
    return unit(q);
}

/// Along the shorter arc from unit quaternion `a` to `b`.
/// Source: Shoemake 1985, "Animating Rotation with Quaternion Curves".
dvec4 alongArc(const dvec4& a, dvec4 b, double share) {
    if (glm::dot(a, b) < 0.0) b = -b;
    // By the difference's length: unlike the product's arc cosine it keeps small angles.
    const dvec4 difference = b - a, sum = b + a;
    const double angle = 2.0 * std::atan2(std::sqrt(glm::dot(difference, difference)), std::sqrt(glm::dot(sum, sum)));
    const double sine = std::sin(angle);
    if (sine == 0.0) return a;
    return unit((std::sin((1.0 - share) * angle) * a + std::sin(share * angle) * b) / sine);
}

}  // namespace

std::vector<double> valueAt(const Keyframes& keyframes, double seconds) {
    const Between at = findBetween(keyframes.times, seconds);
    std::vector<double> value(keyframes.width);
    for (size_t k = 0; k < keyframes.width; ++k) value[k] = between(keyframes, at, k);
    return value;
}

dvec4 rotationAt(const Keyframes& keyframes, double seconds) {
    const Between at = findBetween(keyframes.times, seconds);
    if (at.before == at.after || keyframes.interpolation == Interpolation::step) return rotationOf(keyframes, at.before);
    if (keyframes.interpolation == Interpolation::linear)
        return alongArc(rotationOf(keyframes, at.before), rotationOf(keyframes, at.after), at.share);
    dvec4 q;
    for (int k = 0; k < 4; ++k) q[k] = splineAt(keyframes, at, k);
    return unit(q);
}

}  // namespace raig::gltf

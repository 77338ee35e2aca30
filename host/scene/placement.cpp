#include "scene/placement.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// The linear part, scaled by a power of two so that its largest entry has magnitude [1, 2): products stay in range.
glm::dmat3 tamed(const dmat4& toWorld) {
    glm::dmat3 linear(toWorld);
    double largest = 0.0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) largest = std::max(largest, std::abs(linear[column][row]));
    if (largest == 0.0 || !std::isfinite(largest)) return linear;
    const int exponent = std::ilogb(largest);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) linear[column][row] = std::ldexp(linear[column][row], -exponent);
    return linear;
}

glm::dmat3 cofactorsOf(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

}  // namespace

Placement placementOf(const dmat4& m) {
    // Adding 0 makes a zero of either sign +0: then no sum of placePoint is -0, and placing it once more changes nothing.
    const auto row = [&](int i) { return vec4(dvec4(m[0][i], m[1][i], m[2][i], m[3][i])) + 0.0f; };
    return {row(0), row(1), row(2)};
}

NormalPlacement normalPlacementOf(const dmat4& toWorld) {
    const glm::dmat3 linear = tamed(toWorld), cofactors = cofactorsOf(linear);
    double largest = 0.0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) largest = std::max(largest, std::abs(cofactors[column][row]));
    if (!(largest > 0.0 && std::isfinite(largest))) return {vec3(0.0f), vec3(0.0f), vec3(0.0f)};
    const double scale = std::ldexp(mirrors(toWorld) ? -1.0 : 1.0, -std::ilogb(largest));
    const auto row = [&](int i) {
        vec3 entries(dvec3(cofactors[0][i], cofactors[1][i], cofactors[2][i]) * scale);
        for (int k = 0; k < 3; ++k)
            if (std::abs(entries[k]) < 0x1p-60f) entries[k] = 0.0f;  // no device then meets a number too small for it
        return entries;
    };
    return {row(0), row(1), row(2)};
}

bool mirrors(const dmat4& toWorld) {
    const glm::dmat3 linear = tamed(toWorld);
    return glm::dot(linear[0], glm::cross(linear[1], linear[2])) < 0.0;
}

}  // namespace raig

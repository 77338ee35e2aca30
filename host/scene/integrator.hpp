/// How light is followed: what a picture's pixels hold.
#pragma once

#include <array>
#include <string_view>

namespace raig {

enum class Integrator {
    whitted,  ///< mirrored and transmitted rays, direct and ambient light
    path,     ///< all ways that light takes, by chance
    ao,       ///< ambient occlusion: how much of what is above a surface is open
};

/// By Integrator::path a ray that weighs less than MIN_CONTRIB times this goes on by chance.
inline constexpr float rouletteFactor = 256.0f;

/// Names, in the order of the values.
inline constexpr std::array<std::string_view, 3> integratorNames = {"whitted", "path", "ao"};

}  // namespace raig

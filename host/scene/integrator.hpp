/// How light is followed: what a picture's pixels hold.
#pragma once

#include <array>
#include <string_view>

namespace raig {

enum class Integrator {
    whitted,  ///< mirrored and transmitted rays, direct and ambient light
    ao,       ///< ambient occlusion: how much of what is above a surface is open
};

/// Names, in the order of the values.
inline constexpr std::array<std::string_view, 2> integratorNames = {"whitted", "ao"};

}  // namespace raig

/// Light from where nothing is, as a picture of all directions.
///
/// Directions lie on an octahedron, unfolded to a square: of unit d, q = d / (|dx| + |dy| + |dz|) has (u, v) = (qx, qz)
/// where dy >= 0, and below, what lies beyond the edges of that: (u, v) = ((1 - |qz|) sign qx, (1 - |qx|) sign qz). So [-1,
/// 1]^2 is all of them, the middle +y; and what is within du dv of (u, v) has the solid angle du dv / |q|^3. To go either
/// way takes no more than + - * / and square roots, which all devices have alike; an equirectangular picture would ask for
/// sines. Source: Praun and Hoppe 2003, "Spherical Parametrization and Remeshing".
#pragma once

#include "base/vectors.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace raig {

struct Environment {
    /// Shares of a whole: of each texel in its row, and of each row, as far as the one and all before it.
    static constexpr uint32_t whole = 1u << 24;

    uint32_t side = 0;              ///< texels; even: none lies on both sides of the octahedron's equator by its edges
    std::vector<vec3> texels;       ///< radiance, all over the texel; row by row of v, along u
    std::vector<uint32_t> columns;  ///< of each texel; all 0 in rows without light
    std::vector<uint32_t> rows;     ///< of each row; all 0 if there is no light at all

    bool shines() const { return !rows.empty() && rows.back() > 0; }
};

/// The texels, with the shares in which light is drawn from them: of radiance (luminance .2126 .7152 .0722) times solid
/// angle, in whole multiples of 2^-24, at least one where there is light, so that 24 random bits choose without a bias.
/// Requires an even side from 2 to 4096, side^2 texels, finite and not negative.
Environment makeEnvironment(uint32_t side, std::vector<vec3> texels);

/// Of an equirectangular picture: the top is +y, the middle -z, the right of that +x; `turn` (radians) turns it
/// counterclockwise, seen from above. A pixel counts with its solid angle, all over which it has its radiance times `scale`.
/// The result has about as many texels as the picture, 128^2 at least and 2048^2 at most: 48 MiB and shares.
///
/// Requires width * height pixels, finite and not negative. Cost some 100 operations a pixel, or 2^20 of them, times 6.
Environment fromEquirectangular(std::span<const vec3> pixels, uint32_t width, uint32_t height, double scale, double turn);

}  // namespace raig

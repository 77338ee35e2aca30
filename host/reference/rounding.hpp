/// Float rounding, modelled: which pixels would change if every ray were rounded a little differently?
///
/// A picture has places where the least change of a ray changes what is seen: silhouettes, shadow edges, the rim of a
/// refracting ball. There two renderers that differ only in rounding must differ, and neither is wrong. To find these places
/// without looking at any other renderer, the reference shades each pixel again with its own rays moved, by no more than
/// single precision moves them:
///   - a ray's origin, and a light's sample point, by 2 to 4 units in the last place of the largest coordinate that went
///   into
///     it, on each axis: the corners of its triangle, and these corners seen from the origin of the ray that hit it;
///   - a direction by 2^-23 to 2^-22 on each axis, the error of a few roundings of numbers around 1.
/// Nothing else is changed: not the scene, the random numbers, nor the colours.
#pragma once

#include "base/vectors.hpp"

#include <cstdint>

namespace raig::reference {

/// The value of a float's last bit at magnitude x: 2^(floor(log2 x) - 23), no less than the smallest float.
double floatUlp(double x);

/// One way to round. Deterministic: the same place moves the same way in every run.
class Rounding {
public:
    /// Rounds nothing.
    Rounding() = default;

    /// Variants 2 k and 2 k + 1 move everything in opposite directions, so that an edge is crossed by one of them whichever
    /// side it lies on.
    Rounding(uint32_t pixel, uint32_t sample, uint32_t variant);

    /// Moves `p`, a position computed from coordinates up to `magnitude`. `key` tells apart what is moved.
    dvec3 position(const dvec3& p, double magnitude, uint32_t key) const;

    /// Moves a unit direction. The result is unit length again.
    dvec3 direction(const dvec3& d, uint32_t key) const;

private:
    dvec3 shift(uint32_t key) const;

    uint32_t seed_ = 0;
    double sign_ = 0.0;  ///< 0: rounds nothing
};

}  // namespace raig::reference

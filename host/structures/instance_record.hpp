/// One instance as it lies in memory, and the numbers from which its rays' slack is made.
#pragma once

#include "structures/two_level.hpp"

#include <array>

namespace raig {

/// What walks need of an instance besides its placement, in double precision.
struct InstanceSpace {
    std::array<dvec3, 3> inverse;  ///< rows of the inverse of the linear part
    dvec3 corner;                  ///< where `at` is in the bottom's space
    double spread = 0.0;           ///< the largest sum of a row's magnitudes, with what the inverse may be wrong by
    double blur = 0.0;             ///< see shaders/instances.glsl
    bool invertible = false;
};

/// `inner` maps the bottom's unit to the scene's; `bounds` are the bottom's, and `at` is a point of the scene, both in their
/// unit.
InstanceSpace instanceSpace(const shared::Placement& inner, const Box& bounds, const vec3& at);

/// The placement, its factor from one unit of length to the other taken in. Both are powers of two.
shared::Placement betweenUnits(const shared::Placement& placement, float bottomUnit, float sceneUnit);

/// True if betweenUnits gave `inner` without rounding, in normal floats.
bool isExact(const shared::Placement& placement, const shared::Placement& inner, float bottomUnit, float sceneUnit);

/// True if a bottom of these bounds (in its unit) may be kept under `inner`, its unit's transform to the scene's, where the
/// scene's extent is `extent`: the slack that its rays need is small beside it.
bool fits(const shared::Placement& inner, const Box& bounds, float extent);

/// Writes the record (shaders/shared/structure.glsl). Requires an invertible space.
void writeInstance(uvec4* record, const shared::Placement& inner, const InstanceSpace& space, const vec3& at,
                   uint32_t firstId, uint32_t bottomAt, bool mirrored);

}  // namespace raig

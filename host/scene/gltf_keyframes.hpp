/// Values between keyframes. Internal to the glTF importer (scene/gltf_animation.cpp).
#pragma once

#include "base/vectors.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace raig::gltf {

enum class Interpolation { linear, step, cubicSpline };

/// Keyframes in order of time: `values` holds `width` numbers a keyframe, or, of cubic splines, three times as many: the
/// tangent that comes in, the value, and the tangent that goes out.
struct Keyframes {
    Interpolation interpolation = Interpolation::linear;
    size_t width = 1;
    std::span<const float> times;
    std::span<const float> values;
};

/// The value at `seconds`: the first before the first keyframe, the last after the last.
/// Requires  times that are finite and increase, at least one, and as many values as there must be.
/// Source    glTF 2.0 specification, appendix C.
std::vector<double> valueAt(const Keyframes& keyframes, double seconds);

/// The same of rotations (x, y, z, w), of width 4: linear is along the shorter arc, at constant speed. Of unit length; not
/// finite where there is no rotation (a quaternion of zeros).
dvec4 rotationAt(const Keyframes& keyframes, double seconds);

}  // namespace raig::gltf

/// Scenes whose meshes stand in many places, by transforms ordinary and hostile.
#pragma once

#include "scene/geometry.hpp"

#include <string>
#include <vector>

namespace raig::test {

struct Grove {
    std::string name;
    Scene scene;
};

/// Rotated, scaled (alike and along one axis), sheared, mirrored, nested; very small beside very large; far from the origin;
/// the meshes far from theirs; the whole tiny or huge; some transforms singular or nearly; slivers that rounding makes and
/// unmakes; numbers below the normal ones, and beyond all; the same place twice; meshes that stand once.
std::vector<Grove> groves();

}  // namespace raig::test

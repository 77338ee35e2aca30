/// What files of shaders/shared/ find when they are included as C++, inside `namespace raig::shared`.
#pragma once

#include "base/vectors.hpp"

#include <cstdint>

#include "shared/language.glsl"

namespace raig::shared {

using namespace glm;
using uint = uint32_t;

}  // namespace raig::shared

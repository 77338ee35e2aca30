/// Rays and hits of shaders/shared/rays.glsl, as C++.
#pragma once

#include "base/vectors.hpp"

#include <cstdint>

namespace raig {

namespace shared {
using namespace glm;
using uint = uint32_t;
#include "shared/language.glsl"
#include "shared/rays.glsl"
}  // namespace shared

using shared::Hit;
using shared::NO_HIT;
using shared::Ray;

static_assert(sizeof(Ray) == 32 && sizeof(Hit) == 16, "as in the buffers of the device");

enum class Query : uint32_t { closest, any };

}  // namespace raig

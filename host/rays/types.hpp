/// Rays and hits of shaders/shared/rays.glsl, as C++.
#pragma once

#include "base/shared.hpp"

namespace raig {

namespace shared {
#include "shared/rays.glsl"
}  // namespace shared

using shared::Hit;
using shared::NO_HIT;
using shared::Ray;

static_assert(sizeof(Ray) == 32 && sizeof(Hit) == 16, "as in the buffers of the device");

enum class Query : uint32_t { closest, any };

}  // namespace raig

/// The structs of shaders/shared/frame.glsl, as C++.
#pragma once

#include "rays/types.hpp"
#include "scene/placement.hpp"

namespace raig::shared {

#include "shared/frame.glsl"

static_assert(sizeof(FrameParams) == 256 && sizeof(TileStep) == 20 && sizeof(PathState) == 80 && sizeof(PendingRay) == 64 &&
                  sizeof(PixelResult) == 32 && sizeof(PrimaryHit) == 64,
              "as in the buffers of the device");

}  // namespace raig::shared

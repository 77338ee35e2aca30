/// The scene as the frame's code reads it: one flat array, and the parameters that say where what is.
#pragma once

#include "rays/frame.hpp"
#include "rays/frame_types.hpp"
#include "rays/media.hpp"

#include <vector>

namespace raig {

/// What shaders/shared/frame.glsl describes. Absent things (normals, textures, ...) take no memory.
struct FrameData {
    std::vector<uvec4> elements;
    uint32_t features = 0;       ///< FEATURE_*: of the scene, or of a picture of it, see takeOptions()
    uint32_t sceneFeatures = 0;
    uint32_t sceneShadowRays = 0;
    Media media;
    shared::FrameParams params{};  ///< where what is; camera and picture come from setView(), `slots` from who makes room
};

/// Packs lights, materials, textures and triangles. Requires what renderPicture requires. `keepsUvs`: texture coordinates
/// are packed even where no texture asks for them.
/// Cost: 16 bytes a triangle, 16 to 80 bytes a vertex, and 5 1/3 bytes a texel.
FrameData packFrame(const Scene& scene, const Geometry& geometry, bool keepsUvs = false);

/// Of a vertex that has everything: `vertexStride` at most.
constexpr uint32_t mostVertexElements = 5;

/// Fills in sky, camera and picture: enough for camera rays.
void setView(const Scene& scene, const FrameOptions& options, shared::FrameParams& params);

/// The same, and what media the eye is in.
void setView(const Scene& scene, const Geometry& geometry, const FrameOptions& options, FrameData& data);

/// `features`, and what the camera that the options ask for takes besides.
uint32_t withOptions(uint32_t features, const FrameOptions& options);

/// Makes `data` that of a picture with these options: features that its integrator has no use for are left out, others come
/// in.
void takeOptions(const FrameOptions& options, FrameData& data);

/// Where a pixel of the whole picture is in the part that is rendered, which it lies in, row by row.
inline size_t placeInPart(uint32_t pixel, const shared::FrameParams& params) {
    const uint32_t x = pixel % params.width - params.left, y = pixel / params.width - params.top;
    return size_t{y} * params.partWidth + x;
}

/// The other way.
inline uint32_t pixelAtPlace(uint32_t place, const shared::FrameParams& params) {
    return (params.top + place / params.partWidth) * params.width + params.left + place % params.partWidth;
}

}  // namespace raig

/// From the frame's camera to a raster's clip space: what is drawn of a part of the picture, and what need not be.
#pragma once

#include "base/box.hpp"
#include "rays/frame_types.hpp"

#include <array>

namespace raig {

namespace shared {
#include "shared/items.glsl"
static_assert(sizeof(ItemView) == 80 && sizeof(ItemCall) == 16 && sizeof(ItemWindow) == 16, "as in the device's buffers");
}  // namespace shared

/// Items of a part of the picture: columns and rows, in items from the part's upper left.
struct ItemRect {
    uint32_t x = 0;
    uint32_t y = 0;
    uint32_t width = 0;
    uint32_t height = 0;
};

/// How a scene, in its structure's unit, is drawn into a rectangle of items.
class ItemProjection {
public:
    /// `bounds` are the structure's, in its unit; `scale` items a pixel each way. Nearer than `nearest` along the camera's
    /// axis, in that unit, nothing is drawn (but between a millionth and 1/64 of the farthest point's distance): depths of
    /// floors that begin there are told apart the less well the nearer that is.
    ItemProjection(const shared::FrameParams& frame, const Box& bounds, float unit, const ItemRect& rect, uint32_t scale,
                   double nearest);

    /// False if no point of the box can be seen: it lies beyond one of the sides of what is drawn.
    bool mayShow(const Box& box) const;

    /// How far along the camera's axis the box's middle is, and how many items it is wide at most; seen in perspective.
    double depthOf(const Box& box) const;
    double itemsAcross(const Box& box) const;

    /// As the vertex shader has it.
    shared::ItemView view(uint32_t instancesAt) const;

private:
    dvec4 clip(const dvec3& point) const;

    dvec3 eye_;
    std::array<dvec4, 4> rows_;
    double itemsAUnit_;  ///< at distance 1, or everywhere if the camera is orthographic
    dvec3 forward_;
};

}  // namespace raig

/// What of a scene is seen: a camera moved and turned by hand, and a part of its picture.
#pragma once

#include "scene/scene.hpp"

namespace raig {

/// What is to be different about a camera. What is not given stays as the camera has it; see changedView().
struct ViewChange {
    std::optional<vec3> eye{};    ///< where it stands
    std::optional<vec3> at{};     ///< the point in the middle of the picture
    std::optional<vec3> up{};     ///< the direction that points upwards in the picture, of any length
    std::optional<float> yfov{};  ///< full vertical angle, radians, in (0, pi)

    bool any() const { return eye || at || up || yfov; }
};

/// `camera`, changed.
///
/// Requires  points in range of rays (isInRange).
/// Ensures   - the camera stands at `eye`, and looks at `at`. With `eye` alone it looks at its `target` as before if it has
///             one; else in its direction as before, as the cameras of files have no point that they look at.
///           - axes are orthonormal, the picture's up is as near to `up` as they allow. Without `up`, a camera that is
///             turned has +Y up; one that looks along +Y has its own up, and one that looks along that, too, its own
///             direction. One that is not turned keeps its axes, to the bit.
///           - a camera that mirrors its picture still does.
/// Throws usageError, in the words of the command line, if the eye is where it looks, if `up` is no direction or the one it
/// looks in, and for an angle where the camera is orthographic.
Camera changedView(const Camera& camera, const ViewChange& change);

/// A part of a picture, in pixels from its top left corner.
struct Crop {
    uint32_t x = 0;
    uint32_t y = 0;
    uint32_t width = 0;
    uint32_t height = 0;

    uint64_t pixels() const { return uint64_t{width} * height; }
    bool liesIn(uint32_t wholeWidth, uint32_t wholeHeight) const {
        return width > 0 && height > 0 && uint64_t{x} + width <= wholeWidth && uint64_t{y} + height <= wholeHeight;
    }
};

/// How what is seen around a pixel's middle counts in it.
enum class Filter {
    box,   ///< the pixel itself, evenly
    tent,  ///< evenly less up to the middles of the pixels beside it
    gauss  ///< standard deviation 1/2 pixel, cut off where 2.425 % of the curve are left on either side
};

/// Lets a headlight (a light that casts no shadows: completeScene adds such a one) shine where `camera` looks.
void turnHeadlights(Scene& scene, const Camera& camera);

}  // namespace raig

/// Pictures by the reference, each pixel with how far float rounding alone can move it.
#pragma once

#include "reference/whitted.hpp"
#include "scene/integrator.hpp"
#include "scene/view.hpp"

#include <functional>
#include <optional>

namespace raig::reference {

struct PictureOptions {
    uint32_t width = 256;
    uint32_t height = 256;
    uint32_t samples = 1;  ///< a pixel, at most 65536
    uint32_t camera = 0;   ///< an index into Scene::cameras
    Filter filter = Filter::box;
    Bounds bounds;
    Integrator integrator = Integrator::whitted;
    double reach = INFINITY;     ///< how far ambient occlusion looks
    std::optional<Crop> crop{};  ///< only this part of it
    double aperture = 0.0;       ///< diameter of the lens, in scene units; 0: a pinhole
    double focus = INFINITY;     ///< distance along the camera's axis at which the picture is sharp
    uint32_t roundings = 4;  ///< how often each pixel is shaded again with its rays rounded (see rounding.hpp)
};

/// Pixels row by row from the top, linear RGB; of a part of a picture, that part.
struct Picture {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<dvec3> radiance;
    std::vector<double> discarded;    ///< the weight of the rays not followed, a pixel
    std::vector<double> sensitivity;  ///< the largest change of a channel under the roundings
    std::vector<double> brightest;    ///< largest radiance along a pixel's mirrored and transmitted rays; 0 but of whitted
    std::vector<double> depth;        ///< of the deepest ray that was followed, the mean over a pixel's samples
};

/// The ray of a sample: through the pixel's centre if it is the only one, else through a stratified random place in it, or
/// around it, as dense as the filter is there.
/// Perspective or orthographic; the picture shows at least the height the camera asks for, and all of an orthographic frame.
/// With an aperture, from a stratified random point of a thin lens, across the camera's axis around where the pinhole's ray
/// starts, to where that meets the plane in focus; its numbers have dimension 3.
/// Requires px < width, py < height, sample < options.samples. The direction is unit length.
Ray cameraRay(const Camera& camera, const PictureOptions& options, uint32_t px, uint32_t py, uint32_t sample);

/// Renders by traceRay, tracePath or openness, over all cores; the same bits whatever their number.
///
/// Requires  options.camera < scene.cameras.size(), a size of at least 1 x 1, a crop that lies in it.
/// Ensures   a pixel is the mean of its samples. `progress`, if given, is told the share done from 0 to 1, from any thread
///           but never from two at once.
/// Cost      (1 + roundings) * pixels * samples recursions.
Picture render(const World& world, const PictureOptions& options, const std::function<void(double)>& progress = {});

}  // namespace raig::reference

/// The four standard sets of rays that speed is measured with: the same for raig and its peers.
#pragma once

#include "rays/tracer.hpp"
#include "scene/geometry.hpp"

#include <vector>

namespace raig {

/// Rays of a square picture, and the rays that leave where its primary rays hit. Rays that have no place to start from are
/// left out, the order of the others is kept: 8x8 tiles row by row, Morton order (x in the even bits) inside a tile.
///     primary   closest hit; through pixel centres of the camera below
///     shadow    any hit; to a point light at c + 3 R normalize(-0.6, 1, 0.8), where the surface faces it
///     diffuse   closest hit; cosine-distributed about the normal, by the PCG hash of the pixel's index
///     specular  closest hit; mirrored
/// Everything is computed in double precision and rounded once. Secondary rays start 2e-5 of the hit distance off the
/// surface, so that all peers trace the same rays: for measuring only.
struct RaySets {
    std::vector<Ray> primary, shadow, diffuse, specular;
};

/// A pinhole camera with a square picture.
struct MeasuringCamera {
    dvec3 eye, forward, right, up;  ///< an orthonormal frame
    double tanHalfFov;
};

/// The camera from `framed`'s centre c towards normalize(0.5, 0.35, 1), up +Y, 45 degrees, as near as has every vertex
/// inside `framed` that a triangle names in the middle 95 % of the picture.
MeasuringCamera measuringCamera(const Geometry& geometry, const Box& framed);

/// Makes the sets for a picture of side x side pixels; `side` is a multiple of 8. `tracer` finds what primary rays hit.
RaySets makeRaySets(const Geometry& geometry, const Box& framed, const MeasuringCamera& camera, uint32_t side,
                    Tracer& tracer);

}  // namespace raig

/// The media of a scene: what its glass holds, as shaders/media.glsl tells rays of it.
#pragma once

#include "scene/geometry.hpp"

#include <vector>

namespace raig {

/// What fills a closed surface. Materials that let light through, are not thin, and agree in this hold the same medium.
struct Medium {
    vec3 absorption{0.0f};
    float ior = 1.0f;
};

struct Media {
    std::vector<Medium> media{Medium{}};  ///< by number: air first, then at most 255
    std::vector<uint8_t> ofMaterial;      ///< the number of each material's medium; 0: holds none, or none that is known
    bool nests = false;                   ///< a medium may lie in another, or what absorbs may hold other things

    /// All that one instance has of one medium; `medium` 0: all else of it.
    struct Volume {
        uint32_t instance;
        uint32_t medium;
        Box box;
    };
    std::vector<Volume> volumes;  ///< of known media; empty unless `nests`
    uint32_t openMaterials = 0;  ///< without a known medium, where that matters: not closed, or too many
};

/// Finds them.
///
/// A medium is known if every instance's surface of it is closed: of its triangles that have three different corners each
/// edge belongs to two, which run along it in opposite directions (places count, not indices), and they hold a positive
/// volume. It nests if the box of such a surface meets the box of another medium's, or of another instance's, or, where it
/// absorbs, of anything else. Requires geometry == flatten(scene) or gatherInstances(scene).
/// Cost: O(materials) if nothing is glass; else O(primitives), and where boxes meet O(n log n) of the glass.
Media findMedia(const Scene& scene, const Geometry& geometry);

/// The media that `point` lies in, as rays carry them, the outermost highest: those whose surface winds around it, the one
/// with the nearest surface innermost. A point on a surface is outside. Cost O(primitives of the media whose box it is in).
/// Source: Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle" (winding numbers).
uint32_t mediaAround(const Media& media, const Geometry& geometry, const vec3& point);

}  // namespace raig

/// What pictures of a scene do without, as the scene has nothing of the kind: no more is modelled than it needs.
#pragma once

#include "scene/geometry.hpp"
#include "scene/integrator.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace raig {

/// Something that shading knows and the scene lacks.
struct LeftOut {
    std::string name;
    uint32_t instructions;  ///< SPIR-V instructions that the frame's kernels would have in addition
};

/// Kernels are counted as a device gets them: specialized by what the scene has and by the integrator, without a lens.
struct Economy {
    std::vector<std::string> used;
    std::vector<LeftOut> leftOut;
    uint32_t instructions = 0;     ///< of the frame's kernels for this scene
    uint32_t allInstructions = 0;  ///< of those that leave nothing out
    uint64_t vertices = 0;         ///< in memory
    uint32_t vertexBytes = 0;      ///< of one, as the scene's data hold it
    uint32_t allVertexBytes = 0;   ///< of one that has everything
    uint64_t triangles = 0;        ///< triangles and spheres that rays can meet, instances counted out
    uint64_t storedTriangles = 0;  ///< of them in memory
    uint64_t textureBytes = 0;     ///< of the images in memory
    uint64_t namedTextureBytes = 0;///< had each look-up of a material an image of its own
};

/// Requires  geometry == flatten(scene), or gatherInstances(scene).
/// Cost      that of packing the scene's data, and some 20 specializations of kernels, 10 ms each; no device is asked.
Economy measureEconomy(const Scene& scene, const Geometry& geometry, Integrator integrator = Integrator::whitted);

/// As lines to be read, without the ends of lines.
std::vector<std::string> describe(const Economy& economy);

}  // namespace raig

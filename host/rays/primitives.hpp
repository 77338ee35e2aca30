/// What structures are built over: a scene's geometry, primitive by primitive.
#pragma once

#include "base/parallel.hpp"
#include "scene/geometry.hpp"
#include "structures/structure.hpp"

#include <vector>

namespace raig {

/// The primitive of that global id.
inline Primitive primitiveOf(const Geometry& geometry, uint32_t id) {
    if (geometry.isSphere(id)) return Primitive::sphere(geometry.sphere(id).centre, geometry.sphere(id).radius);
    const uvec3 t = geometry.triangles[id];
    return {geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]};
}

/// All of them, by global id. O(primitives), in parallel.
inline std::vector<Primitive> primitivesOf(const Geometry& geometry) {
    std::vector<Primitive> primitives(geometry.triangles.size());
    parallelFor(primitives.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) primitives[i] = primitiveOf(geometry, static_cast<uint32_t>(i));
    });
    return primitives;
}

}  // namespace raig

/// A scene's geometry as structures are built over it.
#pragma once

#include "scene/geometry.hpp"
#include "structures/two_level.hpp"

namespace raig {

/// Which meshes are worth keeping: those that stand in several places and have that many triangles at least.
struct KeepRule {
    uint32_t leastTriangles = 1;  ///< at least 1
};

/// Smaller meshes are written out. A box of 12 triangles takes some 3 kB so, and 192 to 640 bytes if kept (its record, and
/// its nodes in the top tree, of which there are eight copies up to 2^16 places); but it is traced faster.
inline constexpr KeepRule worthwhile{.leastTriangles = 32};

/// Primitives that would be stored: triangles once for meshes that the rule keeps, all others once an instance. Of all,
/// written out.
struct TriangleCounts {
    uint64_t stored = 0;
    uint64_t writtenOut = 0;
};
TriangleCounts countTriangles(const Scene& scene, const KeepRule& rule);

/// True where writing out at least doubles the triangles. One level is traced faster than two: so less is not worth it.
inline bool isWorthKeeping(const TriangleCounts& counts) {
    return counts.writtenOut > 0 && counts.writtenOut >= 2 * counts.stored;
}

/// The geometry's meshes and where they stand. Requires geometry.isInstanced(); `geometry` must outlive the result.
PlacedScene placedScene(const Geometry& geometry, const KeepRule& rule);

}  // namespace raig

/// What a ray runs through, where glass holds water and water air.
#pragma once

#include "reference/triangle.hpp"
#include "scene/geometry.hpp"
#include "scene/surface.hpp"

#include <vector>

namespace raig::reference {

inline constexpr uint32_t noMedium = 0xffffffffu;

/// Of each material, the medium that its surfaces hold: the first material with the same refraction index and absorption;
/// noMedium where it lets no light through, is thin, or is not known to be closed.
///
/// A medium counts as closed if each instance's surface of it is: every directed edge between two of its corners' places
/// belongs to one triangle, and its opposite to one other (triangles with two corners in one place are passed over), and
/// the volume within is positive. Spheres are closed. Cost O(n log n) of the glass.
std::vector<uint32_t> closedMedia(const Geometry& geometry, const std::vector<Surface>& surfaces);

/// The media that a ray is in, in the order in which it entered them; four at most, the first are forgotten.
class Nest {
public:
    bool isEmpty() const { return media_.empty(); }
    /// The one entered last: the ray runs through it. Requires one.
    uint32_t innermost() const { return media_.back(); }
    void enter(uint32_t medium);
    /// Takes out the one of that kind entered last. False if there is none.
    bool leave(uint32_t medium);

    bool operator==(const Nest&) const = default;

private:
    std::vector<uint32_t> media_;
};

/// The media around a point: what a ray that comes to it from afar is in. Several rays are asked, in fixed directions, and
/// most decide. `ofMaterial` as closedMedia returns it. Cost: O(glass) a direction, in double precision.
Nest mediaAround(const Geometry& geometry, const std::vector<uint32_t>& ofMaterial, const dvec3& point);

}  // namespace raig::reference

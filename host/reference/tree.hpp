/// The oracle's `hit`: the closest triangle or sphere of a ray, by the lecture's recursion, in double precision.
#pragma once

#include "reference/triangle.hpp"
#include "scene/geometry.hpp"

#include <span>
#include <vector>

namespace raig::reference {

inline constexpr uint32_t noTriangle = 0xffffffffu;

/// The point (1 - u - v) a + u b + v c of triangle `primitive` (its global id), at t, or that of a sphere (u = v = 0);
/// noTriangle: the ray hits nothing.
struct Hit {
    double t = std::numeric_limits<double>::infinity();
    double u = 0.0;
    double v = 0.0;
    uint32_t primitive = noTriangle;

    bool operator==(const Hit&) const = default;
};

/// A balanced binary tree of boxes over the usable triangles and spheres of a geometry, which must outlive it.
///
/// They are halved at the median of their centres along the longest side of the centres' box, until at most
/// `leafSize` are left. All leaves are on one level, so the tree needs no links: node i has the children 2 i + 1 and 2 i +
/// 2, and its triangles are an even share of the list. Boxes are padded by 2^-20 of their coordinates, 2^30 times what
/// double precision needs: the tree decides what is tried, never what is hit.
class Tree {
public:
    /// Cost O(n log n) in parallel; some 20 bytes a triangle to keep, 36 while building.
    explicit Tree(const Geometry& geometry);

    /// The closest hit with t in [ray.tMin, ray.tMax]; the lowest id among equal t. Triangles `leaving` and `another` are
    /// passed over; a sphere is not, as a ray in it meets it again: so it must be left from its own side.
    /// An unusable ray hits nothing.
    Hit closest(const Ray& ray, uint32_t leaving = noTriangle, uint32_t another = noTriangle) const;

    /// True if the ray meets a triangle whose material is not marked in `seeThrough` (one entry a material; empty: none is),
    /// other than `leaving` and `arriving`.
    bool blocked(const Ray& ray, std::span<const uint8_t> seeThrough, uint32_t leaving = noTriangle,
                 uint32_t arriving = noTriangle) const;

    const Geometry& geometry() const { return *geometry_; }
    size_t bytes() const { return boxes_.size() * sizeof(Box) + order_.size() * sizeof(uint32_t); }

private:
    static constexpr size_t leafSize = 4;
    struct Item;
    struct Search;

    size_t firstOf(uint32_t level, size_t position) const { return order_.size() * position >> level; }
    void split(std::vector<Item>& items, uint32_t level, size_t position);
    Box leafBox(const std::vector<Item>& items, size_t begin, size_t end) const;
    void hit(Search& search, uint32_t level, size_t position) const;
    void hitLeaf(Search& search, size_t position) const;
    void hitTriangle(Search& search, uint32_t id) const;
    void hitSphere(Search& search, uint32_t id) const;
    static void take(Search& search, const Hit& hit);

    const Geometry* geometry_;
    uint32_t depth_ = 0;           ///< the leaves' level; the root's is 0
    std::vector<Box> boxes_;       ///< level by level
    std::vector<uint32_t> order_;  ///< ids of the usable triangles, leaf by leaf
};

/// The closest hit of every ray, over all cores.
std::vector<Hit> closest(const Tree& tree, std::span<const Ray> rays);

}  // namespace raig::reference

/// A bounding volume hierarchy as textbooks have it, and so with their faults: a control for charts, which must show it
/// failing. Nothing that is rendered or traced comes from here.
#pragma once

#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <span>
#include <vector>

namespace raig::hard::naive {

/// Halved at the median centre along the longest axis; boxes met by the slab test with min and max [Kay, Kajiya 1986],
/// triangles by Moeller and Trumbore's test [1997], in float, without an epsilon. Spheres are left out.
class Bvh {
public:
    explicit Bvh(std::span<const Primitive> primitives);
    size_t bytes() const;
    /// The closest hits, over all cores.
    void trace(std::span<const Ray> rays, std::span<Hit> hits) const;

private:
    struct Node {
        Box box;
        uint32_t first = 0, count = 0;  ///< leaf: of ids_; else `first` is the right child, the left one follows
    };
    uint32_t build(uint32_t begin, uint32_t end, uint32_t depth);
    Hit closest(const Ray& ray) const;

    std::vector<Primitive> triangles_;
    std::vector<uint32_t> ids_;  ///< of triangles_, in order of leaves
    std::vector<Node> nodes_;
};

}  // namespace raig::hard::naive

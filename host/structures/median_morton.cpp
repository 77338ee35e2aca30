#include "base/parallel.hpp"
#include "structures/bvh_builders.hpp"
#include "structures/top_down.hpp"

#include <bit>

namespace raig {

namespace {

/// Puts two zeros before each of the 21 lowest bits.
uint64_t spread(uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    x = (x | x << 2) & 0x1249249249249249;
    return x;
}

struct Coded {
    uint64_t code;
    BoxReference reference;
};

uint64_t mortonCode(const BoxReference& reference, const dvec3& lo, double scale) {
    const dvec3 place = (dvec3(reference.lo) * 0.5 + dvec3(reference.hi) * 0.5 - lo) * scale;
    uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis)
        code |= spread(static_cast<uint64_t>(std::clamp(place[axis], 0.0, 2097151.0))) << axis;
    return code;
}

}  // namespace

BinaryTree buildMedian(std::vector<BoxReference> references, uint32_t maxLeaf) {
    const auto split = [&](const Range& range, BinaryNode& node) {
        return range.count <= maxLeaf ? 0 : halve(range, node);
    };
    BinaryTree tree{{}, std::move(references)};
    TopDown(tree, split).build();
    return tree;
}

BinaryTree buildMorton(std::vector<BoxReference> references, uint32_t maxLeaf) {
    Box bounds;
    for (const BoxReference& r : references) bounds.grow(0.5f * r.lo + 0.5f * r.hi);
    const dvec3 extent = dvec3(bounds.hi) - dvec3(bounds.lo);
    const double widest = std::max({extent.x, extent.y, extent.z});
    const double scale = widest > 0.0 ? 2097151.0 / widest : 0.0;
    std::vector<Coded> coded(references.size());
    parallelFor(coded.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) coded[i] = {mortonCode(references[i], dvec3(bounds.lo), scale), references[i]};
    });
    parallelSort(coded.begin(), coded.end(), [](const Coded& p, const Coded& q) {
        return p.code < q.code || (p.code == q.code && p.reference.id < q.reference.id);
    });
    std::vector<uint64_t> codes(coded.size());
    for (size_t i = 0; i < coded.size(); ++i) {
        codes[i] = coded[i].code;
        references[i] = coded[i].reference;
    }

    BinaryTree tree{{}, std::move(references)};
    const BoxReference* const start = tree.references.data();
    const auto split = [&](const Range& range, BinaryNode& node) -> uint32_t {
        if (range.count <= maxLeaf) return 0;
        const uint64_t *first = codes.data() + (range.begin - start), *last = first + range.count - 1;
        const uint64_t changed = *first ^ *last;
        if (changed == 0 || range.depth >= deepestChoice) {
            node.axis = static_cast<uint32_t>(widestAxis(range.bounds));
            return range.count / 2;
        }
        const int bit = 63 - std::countl_zero(changed);
        node.axis = static_cast<uint32_t>(bit % 3);
        const uint64_t* middle =
            std::partition_point(first, last + 1, [&](uint64_t code) { return (code >> bit & 1) == 0; });
        return static_cast<uint32_t>(middle - first);
    };
    TopDown(tree, split).build();
    return tree;
}

}  // namespace raig

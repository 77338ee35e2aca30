#include "structures/bsp.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/bsp_build.hpp"

#include <algorithm>
#include <chrono>

namespace raig::bsp {

namespace {

constexpr uint64_t mostTriangles = 1u << 27;
constexpr uint64_t referencesPerTriangle = 16;
constexpr uint32_t none = ~0u;

/// Writes the tree as nodes, and the triangles in the order in which leaves first name them.
class Layout {
public:
    Layout(Structure& structure, size_t triangleCount) : structure_(structure), places_(triangleCount, none) {}

    void write(const Node& root) {
        structure_.nodes.resize(1);
        write(root, 0, 1);
        StructureStatistics& statistics = structure_.statistics;
        statistics.sahCost = root.area > 0.0 ? cost_ / root.area : 0.0;
        structure_.header.nodeCount = static_cast<uint32_t>(structure_.nodes.size());
    }
    /// The triangles' ids, in order.
    const std::vector<uint32_t>& order() const { return order_; }

private:
    void write(const Node& node, size_t at, uint32_t depth) {
        StructureStatistics& statistics = structure_.statistics;
        ++statistics.nodes;
        statistics.depth = std::max(statistics.depth, depth);
        cost_ += node.area * (1.0 + static_cast<double>(node.triangles.size()));
        const Node* below = node.children[0].get();
        const Node* above = node.children[1].get();
        if (below == nullptr && above == nullptr) return writeLeaf(node.triangles, at);
        const size_t first = structure_.nodes.size();
        RAIG_CHECK_OP(first, <, indexBits);
        structure_.nodes.resize(first + (below != nullptr && above != nullptr ? 2 : 1));
        const uint32_t empty = (below == nullptr ? noBelowBit : 0) | (above == nullptr ? noAboveBit : 0);
        structure_.nodes[at] = node.plane.encoded(static_cast<uint32_t>(first) | empty);
        if (below != nullptr) write(*below, first, depth + 1);
        if (above != nullptr) write(*above, below != nullptr ? first + 1 : first, depth + 1);
    }

    void writeLeaf(const std::vector<uint32_t>& triangles, size_t at) {
        ++structure_.statistics.leaves;
        structure_.statistics.references += triangles.size();
        const auto size = static_cast<uint32_t>(triangles.size());
        size_t next = 0;
        const auto take = [&](uint32_t count, uint32_t bits) {
            uvec4 node(0, 0, 0, leafBit | bits | count);
            for (uint32_t i = 0; i < count; ++i) node[static_cast<int>(i)] = placeOf(triangles[next++]);
            return node;
        };
        if (size <= 3) {
            structure_.nodes[at] = take(size, 0);
            return;
        }
        structure_.nodes[at] = take(2, moreBit | linkedBit);
        structure_.nodes[at].z = static_cast<uint32_t>(structure_.nodes.size());
        while (next < size) {
            const auto rest = static_cast<uint32_t>(size - next);
            structure_.nodes.push_back(take(std::min(rest, 3u), rest > 3 ? moreBit : 0));
        }
    }

    uint32_t placeOf(uint32_t triangle) {
        if (places_[triangle] == none) {
            places_[triangle] = static_cast<uint32_t>(order_.size());
            order_.push_back(triangle);
        }
        return places_[triangle];
    }

    Structure& structure_;
    std::vector<uint32_t> places_;
    std::vector<uint32_t> order_;
    double cost_ = 0.0;
};

BuildLimits limitsOf(const BuildParams& params, size_t triangles) {
    BuildLimits limits;
    limits.maxLeaf = params.maxLeaf;
    uint32_t log = 0;
    while (size_t{1} << log < triangles) ++log;
    limits.levels = params.maxTreeDepth != 0 ? params.maxTreeDepth : std::min(mostLevels, 16 + 3 * log / 2);
    limits.references = referencesPerTriangle * triangles;
    const uint64_t forTriangles = triangles * shared::TRIANGLE_STRIDE * sizeof(uvec4);
    limits.words = params.memoryBudget > forTriangles ? (params.memoryBudget - forTriangles) / sizeof(uvec4) : 0;
    limits.words = std::min<uint64_t>(limits.words, indexBits);
    return limits;
}

void checkParams(const BuildParams& params, size_t triangles) {
    refuseOtherOptions(params, "bsp", {"--max-leaf", "--max-tree-depth"});
    if (params.maxTreeDepth > mostLevels)
        throw usageError("--max-tree-depth {}: a bsp has at most {} levels", params.maxTreeDepth, mostLevels);
    if (triangles > mostTriangles)
        throw limitError("bsp holds at most {} triangles; the scene has {}", mostTriangles, triangles);
}

}  // namespace

Structure build(std::span<const Primitive> triangles, const BuildParams& params) {
    checkParams(params, triangles.size());
    const auto start = std::chrono::steady_clock::now();
    Structure structure;
    structure.name = "bsp";
    structure.walk = "restart trail";
    structure.header = emptyHeader();

    std::vector<uint32_t> usable;
    Box bounds;
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (!triangles[i].usable()) continue;
        usable.push_back(static_cast<uint32_t>(i));
        bounds.grow(triangles[i].box());
    }
    Layout layout(structure, triangles.size());
    if (!usable.empty()) {
        StructureHeader& header = structure.header;
        header.unit = unitOf(bounds);
        header.lo = bounds.lo * header.unit;
        header.hi = bounds.hi * header.unit;
        header.gridOrigin = header.lo;
        const Tree tree = buildTree(triangles, usable, header, limitsOf(params, usable.size()));
        layout.write(*tree.root);
        if (tree.lacksMemory) structure.remarks.emplace_back("the memory budget stopped bsp from splitting further");
    }
    const std::vector<uint32_t>& order = layout.order();
    structure.header.triangleCount = static_cast<uint32_t>(order.size());
    structure.triangles.resize(order.size() * shared::TRIANGLE_STRIDE);
    parallelFor(order.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            writeReference(structure.triangles, i, triangles[order[i]], order[i], structure.header.unit);
    });
    structure.statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    structure.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

}  // namespace raig::bsp

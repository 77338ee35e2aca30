#include "structures/bvh.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/binned_sah.hpp"
#include "structures/bvh_layout.hpp"

#include <chrono>

namespace raig::bvh {

namespace {

constexpr uint32_t defaultMaxLeaf = 4;
constexpr uint32_t largestLeaf = 15;  // four bits of the leaf word
constexpr uint64_t mostTriangles = 1u << 27;

// A triangle test costs about two node visits on lavapipe.
constexpr SahCosts costs{.node = 1.0f, .triangle = 2.0f};

std::vector<BoxReference> referencesOf(std::span<const Triangle> triangles) {
    std::vector<uint8_t> usable(triangles.size());
    parallelFor(triangles.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) usable[i] = triangles[i].usable();
    });
    std::vector<BoxReference> references;
    references.reserve(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (usable[i] == 0) continue;
        const Box box = triangles[i].box();
        references.push_back({box.lo, static_cast<uint32_t>(i), box.hi, 0});
    }
    return references;
}

void checkParams(const BuildParams& params) {
    refuseOtherOptions(params, "bvh", {"--build", "--walk", "--max-leaf"});
    if (!params.build.empty() && params.build != "binned")
        throw usageError("--build {}: no such builder of bvh; there is binned", params.build);
    if (params.maxLeaf > largestLeaf)
        throw usageError("--max-leaf {}: a leaf of bvh holds 1 to {} triangles", params.maxLeaf, largestLeaf);
}

/// Depth, leaves and SAH cost of the tree.
void measure(const BinaryTree& tree, StructureStatistics& statistics) {
    struct Entry {
        uint32_t node, depth;
    };
    std::vector<Entry> pending;
    if (!tree.nodes.empty()) pending.push_back({0, 1});
    double cost = 0.0;
    while (!pending.empty()) {
        const Entry at = pending.back();
        pending.pop_back();
        const BinaryNode& node = tree.nodes[at.node];
        ++statistics.nodes;
        statistics.depth = std::max(statistics.depth, at.depth);
        cost += node.box.halfArea() * (1.0 + node.count);
        if (node.count > 0) {
            ++statistics.leaves;
            statistics.references += node.count;
        } else {
            pending.push_back({node.left, at.depth + 1});
            pending.push_back({node.right, at.depth + 1});
        }
    }
    const double whole = tree.nodes.empty() ? 0.0 : tree.nodes[0].box.halfArea();
    statistics.sahCost = whole > 0.0 ? cost / whole : 0.0;
}

}  // namespace

Structure build(std::span<const Triangle> triangles, const BuildParams& params) {
    checkParams(params);
    if (triangles.size() > mostTriangles)
        throw limitError("bvh holds at most {} triangles; the scene has {}", mostTriangles, triangles.size());
    const auto start = std::chrono::steady_clock::now();
    const BinaryTree tree =
        buildBinnedSah(referencesOf(triangles), params.maxLeaf == 0 ? defaultMaxLeaf : params.maxLeaf, costs);

    Structure structure;
    structure.name = "bvh";
    structure.header = emptyHeader();
    if (!tree.nodes.empty()) {
        const Box& bounds = tree.nodes[0].box;
        structure.header.unit = unitOf(bounds);
        structure.header.lo = bounds.lo * structure.header.unit;
        structure.header.hi = bounds.hi * structure.header.unit;
    }
    measure(tree, structure.statistics);
    structure.header.nodeCount = static_cast<uint32_t>(structure.statistics.nodes);
    structure.header.triangleCount = static_cast<uint32_t>(tree.references.size());
    layOut(tree, params.walk, structure);

    structure.triangles.resize(tree.references.size() * shared::TRIANGLE_STRIDE);
    parallelFor(tree.references.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uint32_t id = tree.references[i].id;
            writeReference(structure.triangles, i, triangles[id], id, structure.header.unit);
        }
    });
    structure.statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    structure.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

}  // namespace raig::bvh

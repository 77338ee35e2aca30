#include "structures/bvh.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/bvh_builders.hpp"
#include "structures/bvh_layout.hpp"

#include <algorithm>
#include <chrono>

namespace raig::bvh {

namespace {

constexpr uint32_t defaultMaxLeaf = 4;
constexpr uint32_t defaultArity = 4;  // as fast as 2 on lavapipe, and a fifth less memory
constexpr uint32_t largestLeaf = 15;  // four bits of the leaf word
constexpr uint64_t mostTriangles = 1u << 27;

// A triangle test costs about two node visits on lavapipe.
constexpr SahCosts costs{.node = 1.0f, .triangle = 2.0f};

std::vector<BoxReference> referencesOf(std::span<const Primitive> triangles) {
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
    refuseOtherOptions(params, "bvh", {"--build", "--walk", "--bound", "--arity", "--precision", "--max-leaf"});
    const auto check = [](std::string_view option, std::string_view value, std::initializer_list<std::string_view> offered) {
        if (!value.empty() && std::find(offered.begin(), offered.end(), value) == offered.end())
            throw usageError("{} {}: bvh offers {}", option, value, fmt::join(offered, ", "));
    };
    check("--build", params.build, {"binned", "sweep", "median", "lbvh", "sbvh"});
    check("--walk", params.walk, {"auto", "octants", "trail", "skip"});
    check("--bound", params.bound, {"aabb", "sphere", "obb", "kdop"});
    if (params.maxLeaf > largestLeaf)
        throw usageError("--max-leaf {}: a leaf of bvh holds 1 to {} triangles", params.maxLeaf, largestLeaf);
    const bool boxes = params.bound.empty() || params.bound == "aabb";
    if (!boxes && (params.walk == "skip" || params.walk == "trail"))
        throw usageError("--walk {}: only --bound aabb is walked so; leave it out", params.walk);
    if (!boxes && params.precision != 0 && params.precision != 32)
        throw usageError("--precision {}: only --bound aabb has it; leave it out", params.precision);
    if (params.walk == "skip" && params.precision == 16) throw usageError("--precision 16: --walk skip has 32 bits only");
    if (params.precision == 8 && (params.walk == "skip" || params.walk == "octants"))
        throw usageError("--precision 8: only --walk trail has it; leave one of them out");
}

/// Spatial splits may add so many references: three in ten, and what the memory budget leaves.
uint64_t splitBudget(uint64_t references, const BuildParams& params) {
    constexpr uint64_t bytesAReference = shared::TRIANGLE_STRIDE * sizeof(uvec4) + 8 * sizeof(uvec4);
    const uint64_t room = params.memoryBudget / bytesAReference;
    return std::min(references * 3 / 10, room > references ? room - references : 0);
}

BinaryTree buildTree(std::span<const Primitive> triangles, const BuildParams& params, float unit,
                     std::vector<BoxReference> references) {
    const uint32_t maxLeaf = params.maxLeaf == 0 ? defaultMaxLeaf : params.maxLeaf;
    if (params.build == "median") return buildMedian(std::move(references), maxLeaf);
    if (params.build == "lbvh") return buildMorton(std::move(references), maxLeaf);
    if (params.build == "sweep") return buildSweepSah(std::move(references), maxLeaf, costs);
    if (params.build == "sbvh") {
        const uint64_t budget = splitBudget(references.size(), params);
        return buildSpatialSplits(std::move(references), triangles, unit, maxLeaf, costs, budget);
    }
    return buildBinnedSah(std::move(references), maxLeaf, costs);
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
            for (const uint32_t child : tree.childrenOf(node)) pending.push_back({child, at.depth + 1});
        }
    }
    const double whole = tree.nodes.empty() ? 0.0 : tree.nodes[0].box.halfArea();
    statistics.sahCost = whole > 0.0 ? cost / whole : 0.0;
}

}  // namespace

Structure build(std::span<const Primitive> triangles, const BuildParams& given) {
    checkParams(given);
    BuildParams params = given;
    if (params.arity == 0) params.arity = defaultArity;
    if (triangles.size() > mostTriangles)
        throw limitError("bvh holds at most {} triangles; the scene has {}", mostTriangles, triangles.size());
    const auto start = std::chrono::steady_clock::now();
    Structure structure;
    structure.name = "bvh";
    structure.header = emptyHeader();
    std::vector<BoxReference> references = referencesOf(triangles);
    Box bounds;
    for (const BoxReference& reference : references) bounds.grow(Box{reference.lo, reference.hi});
    const float unit = unitOf(bounds);
    if (!references.empty()) {
        structure.header.unit = unit;
        structure.header.lo = bounds.lo * unit;
        structure.header.hi = bounds.hi * unit;
    }
    BinaryTree tree = buildTree(triangles, params, unit, std::move(references));
    if (params.arity > 2) widen(tree, params.arity);
    measure(tree, structure.statistics);
    // Builders leave room for the most nodes that there can be: in large scenes, as much memory as the rest takes.
    if (structure.statistics.nodes < tree.nodes.size() / 2 + 1) compact(tree);
    structure.header.nodeCount = static_cast<uint32_t>(structure.statistics.nodes);
    structure.header.triangleCount = static_cast<uint32_t>(tree.references.size());
    layOut(tree, triangles, params, structure);
    tree.nodes = {};
    tree.wide = {};

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

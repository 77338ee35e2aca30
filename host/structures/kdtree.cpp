#include "structures/kdtree.hpp"

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/parallel.hpp"
#include "structures/kdtree_tree.hpp"

#include <bit>
#include <chrono>

namespace raig::kdtree {

namespace {

constexpr uint64_t mostTriangles = 1u << 27;
constexpr uint32_t mostLevels = 64;  // bits of the walk's trail
constexpr uint64_t mostAddedPerTriangle = 15;
constexpr uint64_t mostWords = uint64_t{7} << 28;  // places of lists are 31 bits

// Measured on bunny and white_room: a test costs a device about as much as a node; planes among bins above 512 references
// cost at most 0.6 % more (SAH) than exact ones and halve the time; the bonus for empty halves is best at 0.9.
constexpr Costs costs{.triangle = 1.0, .emptyBonus = 0.9};
constexpr size_t exactSize = 512;

void checkParams(const BuildParams& params, uint64_t count, uint64_t leastBytes) {
    refuseOtherOptions(params, "kdtree", {"--build", "--walk", "--max-leaf", "--max-tree-depth"});
    if (!params.build.empty() && params.build != "sah" && params.build != "median")
        throw usageError("--build {}: no such builder of kdtree; there are sah and median", params.build);
    if (params.maxTreeDepth > mostLevels)
        throw usageError("--max-tree-depth {}: kdtree has at most {} levels", params.maxTreeDepth, mostLevels);
    if (count > mostTriangles) throw limitError("kdtree holds at most {} triangles; the scene has {}", mostTriangles, count);
    if (leastBytes > params.memoryBudget)
        throw limitError("--memory-budget: kdtree needs at least {} MiB for this scene; allow more", (leastBytes >> 20) + 1);
}

uint32_t walkNamed(std::string_view name) {
    if (name == "auto" || name == "short-stack") return shared::WALK_SHORT_STACK;
    if (name == "restart") return shared::WALK_RESTART;
    throw usageError("--walk {}: no such walk of kdtree; there are auto, short-stack, restart", name);
}

TreeParams treeParams(const BuildParams& params, uint64_t count) {
    // One node and one list.
    const uint64_t least = count * (shared::TRIANGLE_STRIDE * sizeof(uvec4) + sizeof(uint32_t)) + 3 * sizeof(uvec4);
    checkParams(params, count, least);
    TreeParams result;
    result.builder = params.build == "median" ? Builder::median : Builder::sah;
    result.maxLeaf = params.maxLeaf != 0 ? params.maxLeaf : result.builder == Builder::sah ? 1 : 4;
    // The depth of [Havran 2000, "Heuristic Ray Shooting Algorithms"]; the heuristic stops long before it in most cells.
    const auto usual = static_cast<uint32_t>(8.0 + 1.3 * std::log2(static_cast<double>(count) + 1.0));
    result.maxDepth = params.maxTreeDepth != 0 ? params.maxTreeDepth : std::min(usual, mostLevels);
    result.mostAdded = mostAddedPerTriangle * count;
    result.mostWords = std::min((params.memoryBudget - least) / sizeof(uint32_t), mostWords);
    result.costs = costs;
    result.exactSize = exactSize;
    return result;
}

/// The usable triangles' boxes, in the structure's unit.
std::vector<BoxReference> referencesOf(std::span<const Primitive> scaled, const std::vector<uint8_t>& usable) {
    std::vector<BoxReference> references;
    for (size_t i = 0; i < scaled.size(); ++i) {
        if (usable[i] == 0) continue;
        const Box box = scaled[i].box();
        references.push_back({box.lo, static_cast<uint32_t>(i), box.hi, 0});
    }
    return references;
}

/// Writes nodes and lists; triangles in the order in which the lists name them first.
void layOut(const Tree& tree, std::span<const Primitive> triangles, uint64_t count, Structure& structure) {
    const bool bare = tree.nodes.empty();  // the root is a leaf: below a node that cuts nothing off
    const auto end = static_cast<uint32_t>(rootNode + (bare ? 1 : tree.nodes.size()));
    structure.header.nodeCount = end - rootNode;
    structure.nodes.resize(end + (tree.lists.size() + 3) / 4);
    structure.nodes[0] = {end, 4 * end + static_cast<uint32_t>(tree.lists.size()), 0, 0};
    const auto moved = [&](uint32_t word) {
        return word == emptyCell ? word : word + ((word & leafBit) != 0 ? 4 * end : rootNode);
    };
    if (bare) structure.nodes[rootNode] = {std::bit_cast<uint32_t>(structure.header.hi.x), 0, moved(tree.root), emptyCell};
    for (size_t i = 0; i < tree.nodes.size(); ++i) {
        const Node& node = tree.nodes[i];
        structure.nodes[rootNode + i] = {std::bit_cast<uint32_t>(node.plane), node.axis, moved(node.below),
                                         moved(node.above)};
    }

    constexpr uint32_t none = 0xffffffffu;
    std::vector<uint32_t> places(triangles.size(), none);
    uint32_t next = 0;
    structure.triangles.resize(count * shared::TRIANGLE_STRIDE);
    for (size_t i = 0; i < tree.lists.size(); ++i) {
        const uint32_t id = tree.lists[i] & ~lastBit;
        if (places[id] == none) {
            places[id] = next;
            writeReference(structure.triangles, next++, triangles[id], id, structure.header.unit);
        }
        structure.nodes[end + i / 4][static_cast<int>(i % 4)] = places[id] | (tree.lists[i] & lastBit);
    }
    RAIG_CHECK_OP(uint64_t{next}, ==, count);
    structure.header.triangleCount = next;
}

void buildOver(std::span<const Primitive> triangles, const std::vector<uint8_t>& usable, const TreeParams& params,
               Structure& structure) {
    const float unit = structure.header.unit;
    std::vector<Primitive> scaled(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i) scaled[i] = triangles[i].scaled(unit);
    std::vector<BoxReference> references = referencesOf(scaled, usable);
    const uint64_t count = references.size();
    const Box cell{structure.header.lo, structure.header.hi};
    const Tree tree = buildTree(scaled, std::move(references), cell, params);
    if (tree.shortOfMemory) log::note("kdtree: stopped at the memory budget; a larger one may make it faster");
    layOut(tree, triangles, count, structure);
    StructureStatistics& statistics = structure.statistics;
    statistics.nodes = structure.header.nodeCount + tree.leaves;
    statistics.leaves = tree.leaves;
    statistics.depth = tree.depth;
    statistics.references = tree.lists.size();
    statistics.sahCost = cell.halfArea() > 0.0f ? tree.cost / cell.halfArea() : 0.0;
}

}  // namespace

Structure build(std::span<const Primitive> triangles, const BuildParams& params) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<uint8_t> usable(triangles.size());
    parallelFor(triangles.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) usable[i] = triangles[i].usable();
    });
    Box bounds;
    uint64_t count = 0;
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (usable[i] == 0) continue;
        bounds.grow(triangles[i].box());
        ++count;
    }

    Structure structure;
    structure.name = "kdtree";
    structure.header = emptyHeader();
    structure.header.walk = walkNamed(params.walk);
    structure.walk = structure.header.walk == shared::WALK_RESTART ? "restart" : "short-stack";
    const TreeParams parameters = treeParams(params, count);
    if (count > 0) {
        const float unit = unitOf(bounds);
        structure.header.unit = unit;
        structure.header.lo = bounds.lo * unit;
        structure.header.hi = bounds.hi * unit;
        buildOver(triangles, usable, parameters, structure);
    }
    structure.statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    structure.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

}  // namespace raig::kdtree

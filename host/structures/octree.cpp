#include "structures/octree.hpp"

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/parallel.hpp"
#include "structures/octree_tree.hpp"

#include <chrono>
#include <limits>

namespace raig::octree {

namespace {

constexpr uint64_t mostTriangles = 1u << 27;
constexpr uint64_t mostAddedPerTriangle = 19;
constexpr uint64_t mostWords = uint64_t{7} << 28;  // places of lists are 31 bits
constexpr uint32_t inlineReferences = 3;           // that a leaf's record has room for

constexpr uint32_t defaultMaxLeaf = 4;
constexpr uint32_t defaultLevels = 14;
constexpr double recordCost = 1.0;

TreeParams treeParams(const BuildParams& params, uint64_t count) {
    refuseOtherOptions(params, "octree", {"--max-leaf", "--max-tree-depth"});
    if (params.maxTreeDepth > mostLevels)
        throw usageError("--max-tree-depth {}: octree has at most {} levels", params.maxTreeDepth, mostLevels);
    if (count > mostTriangles) throw limitError("octree holds at most {} triangles; the scene has {}", mostTriangles, count);
    const uint64_t least = count * (shared::TRIANGLE_STRIDE * sizeof(uvec4) + sizeof(uint32_t)) + 3 * sizeof(uvec4);
    if (least > params.memoryBudget)
        throw limitError("--memory-budget: octree needs at least {} MiB for this scene; allow more", (least >> 20) + 1);
    TreeParams result;
    result.maxLeaf = params.maxLeaf != 0 ? params.maxLeaf : defaultMaxLeaf;
    result.maxDepth = params.maxTreeDepth != 0 ? params.maxTreeDepth : defaultLevels;
    const uint64_t words = std::min((params.memoryBudget - least) / sizeof(uint32_t), mostWords);
    result.allowance = {mostAddedPerTriangle * count, words};
    result.recordCost = recordCost;
    return result;
}

/// Puts the cube around the bounds.
void setGrid(const Box& bounds, StructureHeader& header) {
    header.lo = bounds.lo;
    header.hi = bounds.hi;
    header.gridOrigin = bounds.lo;
    const vec3 extent = bounds.extent();
    float step = std::max({extent.x, extent.y, extent.z}) / static_cast<float>(side);
    const auto holds = [&] {
        header.gridStep = vec3(step);
        return planeAt(header, side, 0) >= bounds.hi.x && planeAt(header, side, 1) >= bounds.hi.y &&
               planeAt(header, side, 2) >= bounds.hi.z;
    };
    while (!holds()) step = std::nextafter(step, std::numeric_limits<float>::infinity());
}

/// Writes records and lists; triangles in the order in which the lists name them first.
void layOut(const Tree& tree, std::span<const Primitive> triangles, uint64_t count, Structure& structure) {
    constexpr uint32_t none = 0xffffffffu;
    std::vector<uint32_t> places(triangles.size(), none);
    uint32_t next = 0;
    structure.triangles.resize(count * shared::TRIANGLE_STRIDE);
    for (const uint32_t id : tree.lists) {
        if (places[id] != none) continue;
        places[id] = next;
        writeReference(structure.triangles, next++, triangles[id], id, structure.header.unit);
    }
    RAIG_CHECK_OP(uint64_t{next}, ==, count);
    structure.header.triangleCount = next;

    const auto end = static_cast<uint32_t>(rootRecord + tree.records.size());
    structure.header.nodeCount = end - rootRecord;
    uint64_t words = 4 * uint64_t{end};
    for (const Record& r : tree.records) words += r.count > inlineReferences ? r.count : 0;
    structure.nodes.resize((words + 3) / 4);
    structure.nodes[0] = {end, static_cast<uint32_t>(words), 0, 0};
    const auto wordAt = [&](uint64_t at) -> uint32_t& { return structure.nodes[at / 4][static_cast<int>(at % 4)]; };
    auto listed = uint32_t{4} * end;
    for (size_t i = 0; i < tree.records.size(); ++i) {
        const Record& record = tree.records[i];
        const auto index = static_cast<uint32_t>(rootRecord + i);
        if (record.mask != 0) {
            structure.nodes[index] = {rootRecord + record.first, record.mask, 0, 0};
            continue;
        }
        const bool isInline = record.count <= inlineReferences;
        const uint32_t at = isInline ? 4 * index + 1 : listed;
        structure.nodes[index].x = leafBit | at;
        for (uint32_t j = 0; j < record.count; ++j) wordAt(at + j) = places[tree.lists[record.first + j]];
        wordAt(at + record.count - 1) |= lastBit;
        listed += isInline ? 0 : record.count;
    }
}

void buildOver(std::span<const Primitive> triangles, const std::vector<uint8_t>& usable, uint64_t count,
               const TreeParams& params, Structure& structure) {
    const float unit = structure.header.unit;
    std::vector<Primitive> scaled(triangles.size());
    std::vector<uint32_t> ids;
    ids.reserve(count);
    for (size_t i = 0; i < triangles.size(); ++i) {
        scaled[i] = triangles[i].scaled(unit);
        if (usable[i] != 0) ids.push_back(static_cast<uint32_t>(i));
    }
    const Tree tree = buildTree(scaled, std::move(ids), structure.header, params);
    if (tree.shortOfMemory) log::note("octree: stopped at the memory budget; a larger one may make it faster");
    layOut(tree, triangles, count, structure);
    StructureStatistics& statistics = structure.statistics;
    statistics.nodes = tree.records.size();
    statistics.leaves = tree.leaves;
    statistics.depth = tree.depth;
    statistics.references = tree.lists.size();
    // Rays that meet the scene, not all that meet the cube.
    const Box bounds{structure.header.lo, structure.header.hi};
    const double cube = 3.0 * std::pow(double{structure.header.gridStep.x} * side, 2);
    statistics.sahCost = tree.cost * cube / bounds.halfArea();
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
    structure.name = "octree";
    structure.walk = "trail";
    structure.header = emptyHeader();
    const TreeParams parameters = treeParams(params, count);
    if (count > 0) {
        structure.header.unit = unitOf(bounds);
        setGrid({bounds.lo * structure.header.unit, bounds.hi * structure.header.unit}, structure.header);
        buildOver(triangles, usable, count, parameters, structure);
    }
    structure.statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    structure.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

}  // namespace raig::octree

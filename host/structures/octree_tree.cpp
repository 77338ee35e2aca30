#include "structures/octree_tree.hpp"

#include "base/parallel.hpp"
#include "structures/octree.hpp"
#include "structures/triangle_box.hpp"

#include <algorithm>
#include <array>

namespace raig::octree {

namespace {

constexpr size_t parallelSize = 2048;  // references of cells whose parts are tasks of their own
constexpr uint64_t wordsOfRecord = 4;

struct Cell {
    uvec3 low;  // in steps
    uint32_t width;
    uint32_t level;
};

using Octants = std::array<std::vector<uint32_t>, 8>;

class TreeBuilder {
public:
    TreeBuilder(std::span<const Primitive> triangles, const StructureHeader& header, const TreeParams& params)
        : triangles_(triangles), header_(header), params_(params) {}

    /// The subtree of a cell with something in it.
    Tree build(std::vector<uint32_t> ids, const Cell& cell, Allowance allowance) const {
        Tree tree;
        tree.depth = cell.level + 1;
        tree.records.resize(1);
        const uint64_t before = ids.size();
        if (before <= params_.maxLeaf || cell.level >= params_.maxDepth)
            return asLeaf(std::move(ids), cell, std::move(tree));
        Octants octants = octantsOf(ids, cell);
        uint64_t after = 0, parts = 0;
        for (const auto& octant : octants) {
            after += octant.size();
            parts += octant.empty() ? 0 : 1;
        }
        // A line that meets a cube meets an eighth of it with probability 1/4: the ratio of their areas.
        const double cost = 0.25 * (static_cast<double>(after) + params_.recordCost * static_cast<double>(parts));
        if (cost >= static_cast<double>(before)) return asLeaf(std::move(ids), cell, std::move(tree));
        const uint64_t added = after > before ? after - before : 0;
        tree.shortOfMemory = !allowance.hasWords(added, parts * wordsOfRecord);
        if (!allowance.spend(added, parts * wordsOfRecord)) return asLeaf(std::move(ids), cell, std::move(tree));
        ids = {};

        std::array<Tree, 8> below;
        const auto buildOctant = [&](size_t i) {
            if (octants[i].empty()) return;
            const Allowance share = allowance.share(octants[i].size(), after);
            below[i] = build(std::move(octants[i]), octantOf(cell, static_cast<uint32_t>(i)), share);
        };
        if (before >= parallelSize) {
            parallelFor(8, 1, [&](size_t begin, size_t end) {
                for (size_t i = begin; i < end; ++i) buildOctant(i);
            });
        } else {
            for (size_t i = 0; i < 8; ++i) buildOctant(i);
        }
        join(below, cell, tree);
        return tree;
    }

private:
    static Cell octantOf(const Cell& cell, uint32_t octant) {
        const uint32_t half = cell.width / 2;
        return {cell.low + half * uvec3(octant & 1, octant >> 1 & 1, octant >> 2), half, cell.level + 1};
    }

    dvec3 cornerAt(const uvec3& steps) const {
        return {planeAt(header_, steps.x, 0), planeAt(header_, steps.y, 1), planeAt(header_, steps.z, 2)};
    }

    Octants octantsOf(const std::vector<uint32_t>& ids, const Cell& cell) const {
        Octants octants;
        const dvec3 lo = cornerAt(cell.low), middle = cornerAt(cell.low + cell.width / 2),
                    hi = cornerAt(cell.low + cell.width);
        for (const uint32_t id : ids) {
            const Box box = triangles_[id].box();
            const glm::bvec3 below = glm::lessThanEqual(dvec3(box.lo), middle),
                             above = glm::greaterThanEqual(dvec3(box.hi), middle);
            std::optional<PrimitiveBoxTest> test;
            for (uint32_t i = 0; i < 8; ++i) {
                const glm::bvec3 upper(i & 1, i & 2, i & 4);
                if (!glm::all(glm::mix(below, above, upper))) continue;
                if (!test) test.emplace(triangles_[id]);
                if (test->overlaps(glm::mix(lo, middle, upper), glm::mix(middle, hi, upper))) octants[i].push_back(id);
            }
        }
        return octants;
    }

    double areaOf(const Cell& cell) const { return std::ldexp(1.0, -2 * static_cast<int>(cell.level)); }

    Tree asLeaf(std::vector<uint32_t> ids, const Cell& cell, Tree tree) const {
        tree.records[0] = {0, 0, static_cast<uint32_t>(ids.size())};
        tree.cost = areaOf(cell) * (1.0 + static_cast<double>(ids.size()));
        tree.lists = std::move(ids);
        tree.leaves = 1;
        return tree;
    }

    /// The records of the parts after that of the cell, then what is below them, part by part.
    void join(std::array<Tree, 8>& below, const Cell& cell, Tree& tree) const {
        uint32_t mask = 0, parts = 0;
        for (uint32_t i = 0; i < 8; ++i) {
            if (below[i].records.empty()) continue;
            mask |= 1u << i;
            ++parts;
        }
        tree.records[0] = {1, mask, 0};
        tree.records.resize(1 + parts);
        tree.cost = areaOf(cell);
        uint32_t next = 1;
        for (Tree& part : below) {
            if (part.records.empty()) continue;
            const auto words = static_cast<uint32_t>(tree.lists.size());
            // The part's record 1 comes to stand at the end of all so far.
            const auto moved = static_cast<uint32_t>(tree.records.size()) - 1;
            for (Record& r : part.records) r.first += r.mask != 0 ? moved : words;
            tree.records[next++] = part.records[0];
            tree.records.insert(tree.records.end(), part.records.begin() + 1, part.records.end());
            tree.lists.insert(tree.lists.end(), part.lists.begin(), part.lists.end());
            tree.leaves += part.leaves;
            tree.depth = std::max(tree.depth, part.depth);
            tree.cost += part.cost;
            tree.shortOfMemory |= part.shortOfMemory;
            part = {};
        }
    }

    std::span<const Primitive> triangles_;
    const StructureHeader& header_;
    const TreeParams& params_;
};

}  // namespace

Tree buildTree(std::span<const Primitive> triangles, std::vector<uint32_t> ids, const StructureHeader& header,
               const TreeParams& params) {
    return TreeBuilder(triangles, header, params).build(std::move(ids), {uvec3(0), side, 0}, params.allowance);
}

}  // namespace raig::octree

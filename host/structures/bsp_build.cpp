#include "structures/bsp_build.hpp"

#include "base/parallel.hpp"
#include "structures/bsp_split.hpp"

#include <algorithm>
#include <atomic>

namespace raig::bsp {

namespace {

constexpr size_t parallelSize = 512;  // parts, from which on children are built in parallel

/// Words that a leaf of this many triangles takes.
uint64_t leafWords(uint64_t triangles) {
    return triangles <= 3 ? 1 : 1 + (triangles - 2 + 2) / 3;
}

class Builder {
public:
    Builder(std::vector<Corners> corners, double extent, uint32_t maxLeaf)
        : triangles_(std::move(corners)), tolerance_(tolerance * extent), margin_(0x1p-40 * extent), maxLeaf_(maxLeaf) {}

    bool lacksMemory() const { return lacksMemory_; }

    /// Takes the piece, as there may be many at a time.
    std::unique_ptr<Node> build(Piece piece, const BuildLimits& limits) const {
        auto node = std::make_unique<Node>();
        node->area = piece.cell.area();
        const std::optional<Split> split = splitOf(piece, limits);
        std::array<Piece, 2> parts;
        if (split) distribute(piece, *split, parts);
        std::array<BuildLimits, 2> rest;
        if (!split || !separates(piece, parts) || !divide(limits, parts, rest)) {
            for (const Part& part : piece.parts) node->triangles.push_back(part.triangle);
            return node;
        }
        node->plane = split->plane;
        const bool parallel = piece.parts.size() >= parallelSize;
        const Cell cell = std::move(piece.cell);
        piece = Piece{};  // its memory, before there is more
        const auto buildChild = [&](int side) {
            if (parts[side].parts.empty()) return;
            parts[side].cell = cell.part(split->plane, side == 0 ? -1.0 : 1.0);
            node->children[side] = build(std::move(parts[side]), rest[side]);
        };
        if (parallel) {
            parallelInvoke([&] { buildChild(0); }, [&] { buildChild(1); });
        } else {
            buildChild(0);
            buildChild(1);
        }
        return node;
    }

private:
    /// The plane to split by, if there is reason to.
    std::optional<Split> splitOf(const Piece& piece, const BuildLimits& limits) const {
        const size_t count = piece.parts.size();
        if (limits.levels < 2 || count <= maxLeaf_ || (maxLeaf_ == 0 && count < 2)) return std::nullopt;
        const std::optional<Split> split = bestSplit(piece, triangles_, tolerance_, /* dividing= */ false);
        if (split && split->cost < static_cast<double>(count)) return split;
        return maxLeaf_ == 0 ? std::nullopt : bestSplit(piece, triangles_, tolerance_, /* dividing= */ true);
    }

    void distribute(const Piece& piece, const Split& split, std::array<Piece, 2>& parts) const {
        for (const Part& part : piece.parts) {
            const std::span<const dvec3> polygon = piece.polygon(part);
            Sides sides = sidesOf(piece, part, split.plane, tolerance_);
            if (!sides.below && !sides.above) (split.planarAbove ? sides.above : sides.below) = true;
            const bool both = sides.below && sides.above && part.radius == 0.0f;
            for (int side = 0; side < 2; ++side) {
                if (!(side == 0 ? sides.below : sides.above)) continue;
                std::vector<dvec3>& corners = parts[side].corners;
                const auto begin = static_cast<uint32_t>(corners.size());
                if (both) {
                    clip(polygon, split.plane, side == 0 ? -1.0 : 1.0, margin_, corners);
                } else {
                    corners.insert(corners.end(), polygon.begin(), polygon.end());
                }
                parts[side].parts.push_back({part.triangle, begin, static_cast<uint32_t>(corners.size()), part.radius});
            }
        }
    }

    /// What a split promised is an estimate where there are many parts.
    static bool separates(const Piece& piece, const std::array<Piece, 2>& parts) {
        return std::min(parts[0].parts.size(), parts[1].parts.size()) < piece.parts.size();
    }

    /// What is left for each part. False if they would not fit.
    bool divide(const BuildLimits& limits, const std::array<Piece, 2>& parts, std::array<BuildLimits, 2>& rest) const {
        const uint64_t below = parts[0].parts.size(), above = parts[1].parts.size();
        const uint64_t words = 1 + (below > 0 ? leafWords(below) : 0) + (above > 0 ? leafWords(above) : 0);
        if (words > limits.words) lacksMemory_.store(true, std::memory_order_relaxed);
        if (below + above > limits.references || words > limits.words) return false;
        const auto share = [&](uint64_t left) {
            return static_cast<uint64_t>(static_cast<double>(left) * static_cast<double>(below) /
                                         static_cast<double>(below + above));
        };
        const uint64_t references = share(limits.references - below - above), spare = share(limits.words - words);
        rest[0] = rest[1] = limits;
        rest[0].levels = rest[1].levels = limits.levels - 1;
        rest[0].references = below + references;
        rest[1].references = limits.references - rest[0].references;
        rest[0].words = (below > 0 ? leafWords(below) : 0) + spare;
        rest[1].words = limits.words - 1 - rest[0].words;
        return true;
    }

    std::vector<Corners> triangles_;
    double tolerance_, margin_;
    uint32_t maxLeaf_;
    mutable std::atomic<bool> lacksMemory_ = false;
};

}  // namespace

Tree buildTree(std::span<const Primitive> triangles, std::span<const uint32_t> usable, const StructureHeader& header,
               const BuildLimits& limits) {
    const dvec3 lo(header.lo), size = dvec3(header.hi) - lo;
    std::vector<Corners> corners(triangles.size());
    parallelFor(usable.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Primitive t = triangles[usable[i]].scaled(header.unit);
            const std::array<vec3, 3> points = t.isSphere() ? std::array{t.a, t.a, t.a} : std::array{t.a, t.b, t.c};
            for (size_t k = 0; k < 3; ++k) corners[usable[i]][k] = dvec3(points[k]) - lo;
        }
    });
    Piece whole{Cell(size), {}, {}};
    for (const uint32_t triangle : usable) {
        const bool sphere = triangles[triangle].isSphere();
        const auto begin = static_cast<uint32_t>(whole.corners.size());
        whole.corners.insert(whole.corners.end(), corners[triangle].begin(), corners[triangle].begin() + (sphere ? 1 : 3));
        whole.parts.push_back({triangle, begin, static_cast<uint32_t>(whole.corners.size()),
                               sphere ? triangles[triangle].radius() * header.unit : 0.0f});
    }
    const Builder builder(std::move(corners), std::max({size.x, size.y, size.z}), limits.maxLeaf);
    Tree tree;
    tree.root = builder.build(std::move(whole), limits);
    tree.lacksMemory = builder.lacksMemory();
    return tree;
}

}  // namespace raig::bsp

#include "structures/grid_lists.hpp"

#include "base/parallel.hpp"

#include <atomic>

namespace raig::grid {

namespace {

using Counter = std::atomic_ref<uint32_t>;

/// Turns counts, of which the last is 0, into where lists begin.
void sumUp(std::vector<uint32_t>& counts) {
    uint32_t sum = 0;
    for (uint32_t& count : counts) {
        const uint32_t own = count;
        count = sum;
        sum += own;
    }
}

}  // namespace

std::optional<Lists> listCells(const Lattice& lattice, std::span<const Primitive> triangles, uint64_t most) {
    Lists lists;
    lists.begins.assign(lattice.cells() + 1, 0);
    std::atomic<uint64_t> total = 0;
    parallelFor(triangles.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end && total <= most; ++i)
            forEachCell(triangles[i], lattice, [&](size_t cell) {
                Counter(lists.begins[cell]).fetch_add(1, std::memory_order_relaxed);
                return total.fetch_add(1, std::memory_order_relaxed) < most;
            });
    });
    // More than `most` in all if, and only if, the count has passed it: whenever that was noticed.
    if (total > most) return std::nullopt;
    sumUp(lists.begins);
    lists.references.resize(total);
    std::vector<uint32_t> next(lists.begins);
    parallelFor(triangles.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            forEachCell(triangles[i], lattice, [&](size_t cell) {
                lists.references[Counter(next[cell]).fetch_add(1, std::memory_order_relaxed)] = static_cast<uint32_t>(i);
                return true;
            });
    });
    parallelFor(lattice.cells(), 1024, [&](size_t begin, size_t end) {
        for (size_t cell = begin; cell < end; ++cell)
            std::sort(lists.references.begin() + lists.begins[cell], lists.references.begin() + lists.begins[cell + 1]);
    });
    return lists;
}

std::optional<Lists> listParts(const Lattice& lattice, std::span<const Primitive> triangles,
                               std::span<const uint32_t> members, uint64_t most) {
    struct Pair {
        uint32_t cell, member;
    };
    std::vector<Pair> pairs;
    Lists lists;
    lists.begins.assign(lattice.cells() + 1, 0);
    for (const uint32_t member : members) {
        forEachCell(triangles[member], lattice, [&](size_t cell) {
            ++lists.begins[cell];
            pairs.push_back({static_cast<uint32_t>(cell), member});
            return pairs.size() <= most;
        });
        if (pairs.size() > most) return std::nullopt;
    }
    sumUp(lists.begins);
    lists.references.resize(pairs.size());
    std::vector<uint32_t> next(lists.begins);
    for (const Pair& pair : pairs) lists.references[next[pair.cell]++] = pair.member;
    return lists;
}

}  // namespace raig::grid

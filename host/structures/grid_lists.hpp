/// The lists of a grid's cells: which triangles each of them holds (structures/grid.hpp).
#pragma once

#include "structures/grid_shape.hpp"

#include <optional>
#include <span>
#include <vector>

namespace raig::grid {

/// Lists of numbers of triangles, ascending: that of cell i is references[begins[i]] up to begins[i + 1].
struct Lists {
    std::vector<uint32_t> begins;
    std::vector<uint32_t> references;

    std::span<const uint32_t> of(size_t cell) const {
        return std::span(references).subspan(begins[cell], begins[cell + 1] - begins[cell]);
    }
};

/// The lists of a lattice's cells over all triangles; nothing if they would be more than `most` references.
/// Parallel, the same for any number of threads. O(references log(list)).
std::optional<Lists> listCells(const Lattice& lattice, std::span<const Primitive> triangles, uint64_t most);

/// The same over triangles[members[i]], on the calling thread.
std::optional<Lists> listParts(const Lattice& lattice, std::span<const Primitive> triangles,
                               std::span<const uint32_t> members, uint64_t most);

}  // namespace raig::grid

#include "structures/grid.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/grid_lists.hpp"

#include <bit>
#include <chrono>

namespace raig::grid {

namespace {

constexpr uint64_t mostTriangles = 1u << 27;
constexpr double defaultDensity = 4.0;      // cells a triangle, one level
constexpr double defaultTopDensity = 0.25;  // cells a triangle, the upper of two levels
constexpr double partDensity = 4.0;         // parts a triangle of a crowded cell
constexpr uint32_t defaultLevels = 2;
constexpr size_t crowd = 8;  // triangles from which on a cell is divided
// References a triangle: of the one level, of the upper of two, and of both together.
constexpr uint64_t mostReferences = 20, mostInCells = 4;

/// The usable triangles in the structure's unit, in the order in which they lie in memory.
struct Members {
    std::vector<Primitive> triangles;
    std::vector<uint32_t> ids;
    Box bounds;
    float unit = 1.0f;
};

/// Ten bits each of the coordinates in [0, 1], interleaved.
uint32_t mortonCode(const dvec3& point) {
    uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto number = static_cast<uint32_t>(std::clamp(point[axis] * 1024.0, 0.0, 1023.0));
        for (uint32_t bit = 0; bit < 10; ++bit) code |= (number >> bit & 1) << (3 * bit + static_cast<uint32_t>(axis));
    }
    return code;
}

Members membersOf(std::span<const Primitive> triangles) {
    Members members;
    std::vector<uint8_t> usable(triangles.size());
    parallelFor(triangles.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) usable[i] = triangles[i].usable();
    });
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (usable[i] == 0) continue;
        members.ids.push_back(static_cast<uint32_t>(i));
        members.bounds.grow(triangles[i].box());
    }
    if (members.ids.empty()) return members;
    const dvec3 lo(members.bounds.lo), extent = glm::max(dvec3(members.bounds.hi) - lo, 1e-300);
    std::vector<uint64_t> keys(members.ids.size());  // code, then id: no two are equal
    parallelFor(keys.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Box box = triangles[members.ids[i]].box();
            const dvec3 centre = 0.5 * dvec3(box.lo) + 0.5 * dvec3(box.hi);
            keys[i] = uint64_t{mortonCode((centre - lo) / extent)} << 32 | members.ids[i];
        }
    });
    parallelSort(keys.begin(), keys.end());
    members.unit = unitOf(members.bounds);
    members.bounds = {members.bounds.lo * members.unit, members.bounds.hi * members.unit};
    members.triangles.resize(keys.size());
    parallelFor(keys.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            members.ids[i] = static_cast<uint32_t>(keys[i]);
            members.triangles[i] = triangles[members.ids[i]].scaled(members.unit);
        }
    });
    return members;
}

/// A crowded cell's parts.
struct Parts {
    uint32_t cell = 0;
    uint32_t wanted = 0;  // log2 of how many along the longest axis
    Lists lists;
};

/// Words of a crowded cell's parts, in whole blocks of eight.
uint64_t partWords(const Parts& parts) {
    return (firstCell + parts.lists.begins.size() - 1 + 7) / 8 * 8;
}

/// The parts of a cell with these members; none where dividing would make too many references for what it helps.
Parts divide(const Members& members, const Shape& shape, uint32_t cell, std::span<const uint32_t> list, uint64_t most) {
    const uvec3 count = shape.cells.count;
    const uvec3 place(cell % count.x, cell / count.x % count.y, cell / count.x / count.y);
    const double edge = std::cbrt(partDensity * static_cast<double>(list.size()));
    Parts parts{cell, static_cast<uint32_t>(std::clamp(std::round(std::log2(edge)), 1.0, double(fineLog))), {}};
    for (; parts.wanted > 0; --parts.wanted) {
        const Lattice lattice = shape.parts(place, parts.wanted);
        if (lattice.cells() == 1) break;
        if (auto lists = listParts(lattice, members.triangles, list, most)) {
            parts.lists = std::move(*lists);
            return parts;
        }
    }
    parts.wanted = 0;
    return parts;
}

/// Divides all crowded cells, as long as they are within `budget` bytes.
std::vector<Parts> divideCrowded(const Members& members, const Shape& shape, const Lists& lists, uint64_t budget) {
    // Each cell has its share, by its references, of those that are left.
    const uint64_t own = lists.references.size(), all = mostReferences * members.ids.size();
    const double share = own < all ? static_cast<double>(all - own) / static_cast<double>(own) : 0.0;
    std::vector<uint32_t> crowded;
    for (size_t cell = 0; cell + 1 < lists.begins.size(); ++cell)
        if (lists.begins[cell + 1] - lists.begins[cell] > crowd) crowded.push_back(static_cast<uint32_t>(cell));
    std::vector<Parts> divided(crowded.size());
    parallelFor(crowded.size(), 4, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const std::span<const uint32_t> list = lists.of(crowded[i]);
            const auto most = static_cast<uint64_t>(share * static_cast<double>(list.size()));
            divided[i] = divide(members, shape, crowded[i], list, most);
        }
    });
    uint64_t bytes = 0;
    std::erase_if(divided, [&](const Parts& parts) {
        if (parts.wanted == 0) return true;
        const uint64_t own = (partWords(parts) + parts.lists.references.size()) * sizeof(uint32_t);
        if (bytes + own > budget) return true;
        bytes += own;
        return false;
    });
    return divided;
}

struct Grid {
    Shape shape;
    Lists lists;
    std::vector<Parts> parts;
};

/// Bytes of a grid before its crowded cells are divided.
uint64_t bytesOf(const Lattice& cells, uint64_t references, size_t triangles) {
    return (cells.cells() + references + 2 * firstCell) * sizeof(uint32_t) +
           triangles * shared::TRIANGLE_STRIDE * sizeof(uvec4);
}

Grid makeGrid(const Members& members, const BuildParams& params, uint32_t levels) {
    const double given = params.gridDensity;
    const auto count = static_cast<double>(members.triangles.size());
    const double density = given > 0.0 ? given : levels == 1 ? defaultDensity : defaultTopDensity;
    const uint64_t most =
        given > 0.0 ? uint64_t{1} << 31 : (levels == 1 ? mostReferences : mostInCells) * members.ids.size();
    for (double wanted = std::max(1.0, density * count);; wanted = std::max(1.0, wanted / 2.0)) {
        Grid grid{shapeOf(members.bounds, wanted, levels == 2), {}, {}};
        const bool least = wanted == 1.0 || grid.shape.cells.cells() == 1;
        const uint64_t fixed = bytesOf(grid.shape.cells, 0, members.ids.size());
        if (!least && fixed > params.memoryBudget) continue;
        const uint64_t affordable = (std::max(fixed, params.memoryBudget) - fixed) / sizeof(uint32_t);
        auto lists = listCells(grid.shape.cells, members.triangles, least ? uint64_t{1} << 31 : std::min(most, affordable));
        if (!lists) continue;
        grid.lists = std::move(*lists);
        const uint64_t bytes = bytesOf(grid.shape.cells, grid.lists.references.size(), members.ids.size());
        if (levels == 2 && bytes < params.memoryBudget)
            grid.parts = divideCrowded(members, grid.shape, grid.lists, params.memoryBudget - bytes);
        return grid;
    }
}

/// Writes the words of nodes[].
class Writer {
public:
    Writer(const Grid& grid, Structure& structure) : grid_(grid), structure_(structure) {
        const Lattice& cells = grid.shape.cells;
        uint64_t words = firstCell + (cells.cells() + 7) / 8 * 8;
        for (const Parts& parts : grid.parts) {
            partPlaces_.push_back(words);
            words += partWords(parts);
        }
        listWord_ = words;
        references_ = grid.lists.references.size();
        for (const Parts& parts : grid.parts) references_ += parts.lists.references.size();
        if ((listWord_ >> 3) >= 1u << 28 || references_ >= 1u << 31)
            throw limitError("grid: {} words of cells and {} of references are too many; lower --memory-budget", listWord_,
                             references_);
        structure.nodes.assign((listWord_ + references_ + 3) / 4, uvec4(0));
    }

    void write() {
        writeParameters();
        writeLists(grid_.lists, firstCell, 0);
        uint64_t reference = grid_.lists.references.size();
        for (size_t i = 0; i < grid_.parts.size(); ++i) {
            const Parts& parts = grid_.parts[i];
            uint32_t& cell = word(firstCell + parts.cell);
            word(partPlaces_[i]) = cell;
            cell = crowdedBit | parts.wanted << 28 | static_cast<uint32_t>(partPlaces_[i] / 8);
            writeLists(parts.lists, partPlaces_[i] + firstCell, reference);
            reference += parts.lists.references.size();
        }
    }

private:
    uint32_t& word(uint64_t index) { return structure_.nodes[index / 4][static_cast<int>(index % 4)]; }

    void writeParameters() {
        const Shape& shape = grid_.shape;
        uint32_t divisions = 0;
        for (int axis = 0; axis < 3; ++axis) divisions |= (shape.coarser[axis] | shape.finest[axis] << 4) << 8 * axis;
        structure_.nodes[0] = uvec4(shape.cells.count, std::bit_cast<uint32_t>(static_cast<float>(shape.cells.margin)));
        structure_.nodes[1] = uvec4(static_cast<uint32_t>(listWord_ / 4), static_cast<uint32_t>(references_), divisions, 0u);
    }

    void writeLists(const Lists& lists, uint64_t cellWord, uint64_t reference) {
        parallelFor(lists.begins.size() - 1, 4096, [&](size_t begin, size_t end) {
            for (size_t cell = begin; cell < end; ++cell) {
                const std::span<const uint32_t> list = lists.of(cell);
                if (list.empty()) continue;
                const uint64_t first = reference + lists.begins[cell];
                word(cellWord + cell) = static_cast<uint32_t>(first + 1);
                for (size_t i = 0; i < list.size(); ++i)
                    word(listWord_ + first + i) = list[i] | (i + 1 == list.size() ? lastBit : 0);
            }
        });
    }

    const Grid& grid_;
    Structure& structure_;
    std::vector<uint64_t> partPlaces_;
    uint64_t listWord_ = 0, references_ = 0;
};

/// The area of all cells' surfaces, each with what its visit costs, over that of the grid.
void addCosts(const Lattice& lattice, const Lists& lists, double& cost, StructureStatistics& statistics) {
    const dvec3 s = lattice.step;
    const double area = s.x * s.y + s.y * s.z + s.z * s.x;
    const size_t cells = lists.begins.size() - 1;
    statistics.nodes += cells;
    statistics.references += lists.references.size();
    for (size_t i = 0; i < cells; ++i) statistics.leaves += lists.begins[i + 1] > lists.begins[i];
    cost += area * static_cast<double>(cells + lists.references.size());
}

void measure(const Grid& grid, Structure& structure) {
    StructureStatistics& statistics = structure.statistics;
    const Lattice& cells = grid.shape.cells;
    double cost = 0.0;
    addCosts(cells, grid.lists, cost, statistics);
    const dvec3 s = cells.step;
    for (const Parts& parts : grid.parts) {
        const uvec3 count = cells.count;
        const uvec3 place(parts.cell % count.x, parts.cell / count.x % count.y, parts.cell / count.x / count.y);
        addCosts(grid.shape.parts(place, parts.wanted), parts.lists, cost, statistics);
        // Its own list is for rays from far off only.
        cost -= (s.x * s.y + s.y * s.z + s.z * s.x) * static_cast<double>(grid.lists.of(parts.cell).size());
    }
    const dvec3 whole = dvec3(cells.count) * s;
    statistics.sahCost = cost / (whole.x * whole.y + whole.y * whole.z + whole.z * whole.x);
    statistics.depth = grid.parts.empty() ? 1 : 2;
    structure.header.nodeCount = static_cast<uint32_t>(statistics.nodes);
}

}  // namespace

Structure build(std::span<const Primitive> triangles, const BuildParams& params) {
    refuseOtherOptions(params, "grid", {"--grid-density", "--levels"});
    if (triangles.size() > mostTriangles)
        throw limitError("grid holds at most {} triangles; the scene has {}", mostTriangles, triangles.size());
    const auto start = std::chrono::steady_clock::now();
    const uint32_t levels = params.levels == 0 ? defaultLevels : params.levels;
    if (levels > 2) throw usageError("--levels {}: a grid has 1 or 2", levels);
    Structure structure;
    structure.name = "grid";
    structure.walk = levels == 1 ? "one level" : "two levels";
    structure.header = emptyHeader();
    structure.header.walk = levels - 1;
    const Members members = membersOf(triangles);
    if (!members.ids.empty()) {
        const Grid grid = makeGrid(members, params, levels);
        structure.header.unit = members.unit;
        structure.header.lo = members.bounds.lo;
        structure.header.hi = members.bounds.hi;
        structure.header.gridOrigin = vec3(grid.shape.cells.origin);
        structure.header.gridStep = vec3(grid.shape.cells.step);
        structure.header.triangleCount = static_cast<uint32_t>(members.ids.size());
        Writer(grid, structure).write();
        measure(grid, structure);
        structure.triangles.resize(members.ids.size() * shared::TRIANGLE_STRIDE);
        parallelFor(members.ids.size(), 4096, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                writeReference(structure.triangles, i, triangles[members.ids[i]], members.ids[i], members.unit);
        });
    }
    structure.statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    structure.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

}  // namespace raig::grid

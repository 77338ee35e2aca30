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
constexpr double nestedDensity = 12.0;      // and of a crowded part: there most of the triangles are, so it pays
constexpr uint32_t defaultLevels = 2;
constexpr size_t crowd = 8, crowdInPart = 12;  // triangles in a cell, or in a part, beyond which it is divided
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

/// A crowded cell's parts, or a crowded part's.
struct Parts {
    size_t cell = 0;      // which of the cells, or parts, around it
    uint32_t more = 0;    // log2 of how many along the longest axis
    Lattice lattice;
    Lists lists;
    std::vector<Parts> nested;
};

/// Words of a block, in whole blocks of eight.
uint64_t partWords(const Parts& parts) {
    return (firstCell + parts.lists.begins.size() - 1 + 7) / 8 * 8;
}

double areaOf(const dvec3& size) { return size.x * size.y + size.y * size.z + size.z * size.x; }

/// What rays that meet the cell that is divided are expected to do in its parts: one for each that is visited, and for each
/// triangle tested.
double costOf(const Lattice& parts, size_t references) {
    const dvec3 whole = parts.step * dvec3(parts.count);
    return areaOf(parts.step) / areaOf(whole) * static_cast<double>(parts.cells() + references);
}

std::vector<Parts> divideAll(const Members& members, const Shape& shape, const Parts& around, const Place& place,
                             uint64_t most);

/// The parts of a cell with these members, in at most `most` references; none where it would help too little.
Parts divide(const Members& members, const Shape& shape, size_t cell, const Place& place, std::span<const uint32_t> list,
             uint64_t most) {
    const double edge = std::cbrt((place.wanted > 0 ? nestedDensity : partDensity) * static_cast<double>(list.size()));
    Parts parts{cell, static_cast<uint32_t>(std::clamp(std::round(std::log2(edge)), 1.0, double(blockLog))), {}, {}, {}};
    for (; parts.more > 0; --parts.more) {
        parts.lattice = shape.parts(place, parts.more);
        if (parts.lattice.cells() == 1) continue;
        auto lists = listParts(parts.lattice, members.triangles, list, most);
        if (!lists) continue;
        // A cell is divided for the sake of rays in it, a part if rays through all of it gain.
        if (place.wanted > 0 && costOf(parts.lattice, lists->references.size()) > 0.75 * double(list.size())) break;
        parts.lists = std::move(*lists);
        if (shape.nested) parts.nested = divideAll(members, shape, parts, place, most - parts.lists.references.size());
        return parts;
    }
    parts.more = 0;
    return parts;
}

/// Divides the cells that are crowded, each in its share of `most` references, by its own.
template <class PlaceOf>
std::vector<Parts> divideCrowded(const Members& members, const Shape& shape, const Lists& lists, size_t limit, uint64_t most,
                                 const PlaceOf& placeOf) {
    std::vector<size_t> crowded;
    uint64_t held = 0;
    for (size_t cell = 0; cell + 1 < lists.begins.size(); ++cell)
        if (lists.of(cell).size() > limit) {
            crowded.push_back(cell);
            held += lists.of(cell).size();
        }
    const double share = static_cast<double>(most) / static_cast<double>(std::max<uint64_t>(held, 1));
    std::vector<Parts> divided(crowded.size());
    parallelFor(crowded.size(), 4, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const std::span<const uint32_t> list = lists.of(crowded[i]);
            divided[i] = divide(members, shape, crowded[i], placeOf(crowded[i]), list,
                                static_cast<uint64_t>(share * static_cast<double>(list.size())));
        }
    });
    std::erase_if(divided, [](const Parts& parts) { return parts.more == 0; });
    return divided;
}

std::vector<Parts> divideAll(const Members& members, const Shape& shape, const Parts& around, const Place& place,
                             uint64_t most) {
    return divideCrowded(members, shape, around.lists, crowdInPart, most,
                         [&](size_t part) { return shape.part(place, around.more, part); });
}

/// Leaves out what does not fit into `budget` bytes.
void keepWithin(std::vector<Parts>& divided, uint64_t& budget) {
    std::erase_if(divided, [&](const Parts& parts) {
        const uint64_t own = (partWords(parts) + parts.lists.references.size()) * sizeof(uint32_t);
        if (own > budget) return true;
        budget -= own;
        return false;
    });
    for (Parts& parts : divided) keepWithin(parts.nested, budget);
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

Grid makeGrid(const Members& members, const BuildParams& params, uint32_t walk) {
    const double given = params.gridDensity;
    const auto count = static_cast<double>(members.triangles.size());
    const double density = given > 0.0 ? given : walk == 0 ? defaultDensity : defaultTopDensity;
    const uint64_t most =
        given > 0.0 ? uint64_t{1} << 31 : (walk == 0 ? mostReferences : mostInCells) * members.ids.size();
    for (double wanted = std::max(1.0, density * count);; wanted = std::max(1.0, wanted / 2.0)) {
        Grid grid{shapeOf(members.bounds, wanted, walk), {}, {}};
        const bool least = wanted == 1.0 || grid.shape.cells.cells() == 1;
        const uint64_t fixed = bytesOf(grid.shape.cells, 0, members.ids.size());
        if (!least && fixed > params.memoryBudget) continue;
        const uint64_t affordable = (std::max(fixed, params.memoryBudget) - fixed) / sizeof(uint32_t);
        auto lists = listCells(grid.shape.cells, members.triangles, least ? uint64_t{1} << 31 : std::min(most, affordable));
        if (!lists) continue;
        grid.lists = std::move(*lists);
        const uint64_t bytes = bytesOf(grid.shape.cells, grid.lists.references.size(), members.ids.size());
        if (walk != 0 && bytes < params.memoryBudget) {
            const uint64_t own = grid.lists.references.size(), all = mostReferences * members.ids.size();
            grid.parts = divideCrowded(members, grid.shape, grid.lists, crowd, own < all ? all - own : 0,
                                       [&](size_t cell) { return grid.shape.cell(cell); });
            uint64_t left = params.memoryBudget - bytes;
            keepWithin(grid.parts, left);
        }
        return grid;
    }
}

/// True if a part holds so many triangles still that it should have parts.
bool isCrowded(const Parts& parts) {
    for (size_t part = 0; part + 1 < parts.lists.begins.size(); ++part)
        if (parts.lists.of(part).size() > 2 * crowdInPart) return true;
    return false;
}

/// Makes a grid of two levels, or, where those are not enough and it helps, a nested one.
Grid makeDividedGrid(const Members& members, const BuildParams& params, uint32_t& walk) {
    Grid grid = makeGrid(members, params, walk);
    if (!params.nestsGrids && std::none_of(grid.parts.begin(), grid.parts.end(), isCrowded)) return grid;
    Grid nested = makeGrid(members, params, nestedWalk);
    if (!params.nestsGrids &&
        std::all_of(nested.parts.begin(), nested.parts.end(), [](const Parts& parts) { return parts.nested.empty(); }))
        return grid;
    walk = nestedWalk;
    return nested;
}

/// Writes the words of nodes[].
class Writer {
public:
    Writer(const Grid& grid, Structure& structure) : grid_(grid), structure_(structure) {
        const Lattice& cells = grid.shape.cells;
        uint64_t words = firstCell + (cells.cells() + 7) / 8 * 8;
        references_ = grid.lists.references.size();
        addBlocks(grid.parts, 0, words);
        listWord_ = words;
        if ((listWord_ >> 3) >= 1u << 28 || references_ >= 1u << 31)
            throw limitError("grid: {} words of cells and {} of references are too many; lower --memory-budget", listWord_,
                             references_);
        structure.nodes.assign((listWord_ + references_ + 3) / 4, uvec4(0));
    }

    void write() {
        writeParameters();
        writeLists(grid_.lists, firstCell, 0);
        uint64_t reference = grid_.lists.references.size();
        for (const Block& block : blocks_) {
            const Parts& parts = *block.parts;
            uint32_t& cell = word(block.around + firstCell + parts.cell);
            word(block.place) = cell;
            if (grid_.shape.nested) word(block.place + 1) = std::bit_cast<uint32_t>(grid_.shape.reachOf(parts.lattice));
            cell = crowdedBit | parts.more << 28 | static_cast<uint32_t>(block.place / 8);
            writeLists(parts.lists, block.place + firstCell, reference);
            reference += parts.lists.references.size();
        }
    }

private:
    struct Block {
        const Parts* parts;
        uint64_t place, around;  // its first word, and that of the block it is in; 0: the grid
    };

    /// Blocks come after those they are in.
    void addBlocks(const std::vector<Parts>& divided, uint64_t around, uint64_t& words) {
        for (const Parts& parts : divided) {
            const uint64_t place = words;
            blocks_.push_back({&parts, place, around});
            words += partWords(parts);
            references_ += parts.lists.references.size();
            addBlocks(parts.nested, place, words);
        }
    }

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
    std::vector<Block> blocks_;
    uint64_t listWord_ = 0, references_ = 0;
};

/// The area of all cells' surfaces, each with what its visit costs, over that of the grid.
void addCosts(const Lattice& lattice, const Lists& lists, const std::vector<Parts>& divided, uint32_t depth, double& cost,
              StructureStatistics& statistics) {
    const double area = areaOf(lattice.step);
    const size_t cells = lists.begins.size() - 1;
    statistics.nodes += cells;
    statistics.references += lists.references.size();
    statistics.depth = std::max(statistics.depth, depth);
    for (size_t i = 0; i < cells; ++i) statistics.leaves += lists.begins[i + 1] > lists.begins[i];
    cost += area * static_cast<double>(cells + lists.references.size());
    for (const Parts& parts : divided) {
        addCosts(parts.lattice, parts.lists, parts.nested, depth + 1, cost, statistics);
        // Its own list is for rays from far off only.
        cost -= area * static_cast<double>(lists.of(parts.cell).size());
    }
}

void measure(const Grid& grid, Structure& structure) {
    const Lattice& cells = grid.shape.cells;
    double cost = 0.0;
    addCosts(cells, grid.lists, grid.parts, 1, cost, structure.statistics);
    structure.statistics.sahCost = cost / areaOf(dvec3(cells.count) * cells.step);
    structure.header.nodeCount = static_cast<uint32_t>(structure.statistics.nodes);
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
        const Grid grid =
            levels == 1 ? makeGrid(members, params, 0) : makeDividedGrid(members, params, structure.header.walk);
        if (grid.shape.nested) structure.walk = "two levels, nested";
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

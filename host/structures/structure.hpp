/// What all acceleration structures have in common: flat arrays, ready to be copied to a device and walked there.
#pragma once

#include "base/box.hpp"
#include "base/shared.hpp"
#include "base/triangle.hpp"
#include "base/vectors.hpp"

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace raig {

namespace shared {
#include "shared/structure.glsl"
}  // namespace shared

using shared::StructureHeader;
static_assert(sizeof(StructureHeader) == 64, "as in the device's buffer");

enum class PrimitiveKind : uint32_t { triangle = 0, sphere = 1 };

/// A primitive to build over: a triangle, or a sphere (the surface, not what is in it). Its id is its index in the span.
/// Every builder leaves out those that are not usable().
struct Primitive {
    vec3 a;  ///< of a sphere: the centre
    vec3 b;  ///< of a sphere: (radius, 0, 0)
    vec3 c;  ///< of a sphere: 0
    PrimitiveKind kind = PrimitiveKind::triangle;

    static Primitive sphere(const vec3& centre, float radius) {
        return {centre, vec3(radius, 0.0f, 0.0f), vec3(0.0f), PrimitiveKind::sphere};
    }
    bool isSphere() const { return kind == PrimitiveKind::sphere; }
    vec3 centre() const { return a; }
    float radius() const { return b.x; }

    /// Holds all of the primitive: of a triangle exactly, of a sphere rounded outwards.
    Box box() const;
    bool usable() const { return isSphere() ? isUsableSphere(a, b.x) : isUsable(a, b, c); }
    /// In another unit of length: exact for powers of two.
    Primitive scaled(float unit) const { return {a * unit, b * unit, c * unit, kind}; }
};
static_assert(sizeof(Primitive) == 40, "nothing in it is padding: structure files hash it");

/// Where it says so, a primitive that is a triangle.
using Triangle = Primitive;

/// Options of all builders, each with the builders that read it. Names are as on the command line.
struct BuildParams {
    std::string build = "";     ///< bvh: median, binned, sweep, sbvh, lbvh; kdtree: median, sah. Empty: the default
    std::string walk = "auto";  ///< bvh: skip, octants, trail; kdtree: short-stack, restart. Or auto
    std::string bound = "";     ///< bvh: aabb, sphere, obb, kdop. Empty: aabb
    uint32_t arity = 0;         ///< bvh: most children of a node, 2, 4 or 8; 0: the default
    uint32_t precision = 0;     ///< bvh: bits of a box's plane, 32, 16 or 8; 0: as suits the scene
    uint32_t maxLeaf = 0;       ///< most triangles in a leaf (MAX_OBJ); 0: the structure's default
    uint32_t maxTreeDepth = 0;  ///< levels of a tree (MAX_DEPTH); 0: the structure's default
    float gridDensity = 0.0f;   ///< cells a triangle; 0: the structure's default
    uint32_t levels = 0;        ///< of a grid, 1 or 2; 0: the structure's default
    bool nestsGrids = false;    ///< no option: a grid of two levels is nested even where that does not help
    uint64_t memoryBudget = uint64_t{4} << 30;  ///< most bytes of a built structure: builders stop subdividing before it
};

/// The options that differ from their defaults, as on the command line: "--walk skip --max-leaf 4". Empty if none does.
std::string describeOptions(const BuildParams& params);

/// Throws usageError if an option is given that is not among `offered` (as on the command line, "--max-leaf" say).
/// The memory budget is every structure's.
void refuseOtherOptions(const BuildParams& params, std::string_view structure,
                        std::initializer_list<std::string_view> offered);

struct StructureStatistics {
    uint64_t nodes = 0;  ///< of one copy of the tree
    uint64_t leaves = 0;
    uint32_t depth = 0;
    uint64_t references = 0;  ///< triangles in leaves, repeated ones counted each time
    uint64_t bytes = 0;       ///< of nodes and triangles, all copies
    double sahCost = 0.0;     ///< expected cost of a random ray: 1 a node, 1 a triangle, by surface area
    double seconds = 0.0;     ///< to build
};

/// The structure of one mesh that is stored once, or of all that is written out.
struct Bottom {
    static constexpr uint32_t writtenOut = 0xffffffffu;
    uint32_t mesh = writtenOut;   ///< ids of its references are triangles of this mesh; or global ids
    uint64_t firstReference = 0;  ///< in Structure::triangles, in references
    uint64_t references = 0;
};

/// A built structure: a value. The meaning of `nodes` belongs to the structure's own pair of host/structures/NAME.cpp and
/// shaders/structures/NAME.glsl.
struct Structure {
    std::string name;  ///< its line in registry.def
    std::string walk;  ///< the walk it is laid out for, in words
    StructureHeader header{};
    std::vector<uvec4> nodes;
    std::vector<uvec4> triangles;  ///< three a reference (shaders/shared/structure.glsl)
    StructureStatistics statistics;
    /// Of two levels (structures/two_level.hpp): whose references lie where in `triangles`. Empty: there is one level.
    std::vector<Bottom> bottoms;
    uint32_t instances = 0;  ///< of two levels: how many there are
    std::vector<std::string> remarks;  ///< what a person should know, such as that the memory budget stopped the builder

    /// The file of shaders/structures/ that has its walk, without its ending: of the structure's name, and for some walks of
    /// bvh another.
    std::string_view walkFile() const;

    /// Marks the references to primitives i with seeThrough[i] != 0 as no obstacle to shadow rays.
    /// Requires a flag for each primitive that the structure was built over, and one level.
    void markSeeThrough(std::span<const uint8_t> seeThrough);
    /// The same of references [first, first + count), for ids for which `isSeeThrough` holds.
    void markSeeThrough(const std::function<bool(uint32_t)>& isSeeThrough, uint64_t first = 0,
                        uint64_t count = ~uint64_t{0});

    /// True if a reference is a sphere: walks that need not test any are compiled without. O(references), in parallel.
    bool hasSpheres() const;

    /// True if the arrays hold two levels, as shared/structure.glsl describes.
    bool isInstanced() const { return !bottoms.empty(); }
};

/// One line of registry.def: how a structure is built and checked.
struct StructureType {
    std::string_view name;
    /// Pure: the same triangles and parameters give the same bytes, on any number of threads. Empty spans are fine.
    /// Throws usageError for a parameter it does not offer.
    Structure (*build)(std::span<const Primitive>, const BuildParams&);
    /// Names the first broken invariant, or nothing if all hold: then every walk ends, reads only what is there, and finds
    /// what it should. Stands any values in nodes, triangles and header, as they may come from a file; a header.walk that
    /// the structure does not have is a fault.
    std::optional<std::string> (*findFault)(const Structure&, std::span<const Primitive>);
};

/// All structures, in the order of registry.def.
std::span<const StructureType> structureTypes();

/// The structure of that name. Throws usageError, which lists those there are.
const StructureType& structureType(std::string_view name);

/// The power of two that brings the largest magnitude of a coordinate of the box to [1, 2): the header's `unit`. At least
/// 2^-62 and at most 2^120. 1 for an empty box.
float unitOf(const Box& bounds);

/// Writes reference `index` to primitive `id`, scaled by the unit, into the array that walks read.
void writeReference(std::vector<uvec4>& references, size_t index, const Primitive& primitive, uint32_t id, float unit);

/// The primitive, in the structure's unit of length, and the id of reference `index`.
Primitive referencedPrimitive(const Structure& structure, uint64_t index);
uint32_t referencedId(const Structure& structure, uint64_t index);

/// True if the reference has the kind and the corners, or centre and radius, of the primitive, scaled.
bool refersTo(const Structure& structure, uint64_t index, const Primitive& primitive);

/// The header of a structure with nothing in it.
StructureHeader emptyHeader();

}  // namespace raig

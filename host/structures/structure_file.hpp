/// Built structures in files, so that a scene need not be built over again.
///
/// A file is a header of fixed size; of two levels, the table of bottoms; then the nodes and the triangles as they lie in
/// memory. The header holds the version of the format, a mark that tells the order of bytes, the structure's name and the
/// options it was built with, its sizes, a hash of the scene it was built over (structures/scene_hash.hpp), and checksums of
/// itself and of the rest (XXH3 [Collet 2019]).
///
/// Nothing that a file says is believed, but for what is only shown: its statistics and what its walk is called. Sizes are
/// checked against the file's before memory is taken. Checksums tell accidents; against intent, a structure is used only if
/// it keeps every invariant over the scene's own triangles (structures/structure_fault.hpp): its walks then end, stay inside
/// the arrays and find what they should. That finds most files of an older layout, too. Reading a bvh with all checks takes
/// some third of the time of building it.
///
/// Marks of triangles that let light through are not kept: they belong to the scene's materials.
#pragma once

#include "base/error.hpp"
#include "base/input_file.hpp"
#include "structures/scene_hash.hpp"

#include <array>
#include <filesystem>

namespace raig {

/// The start of a file, as it lies there. Names end in zeros.
struct StructureFileHeader {
    std::array<char, 8> magic;
    uint32_t byteOrder;
    uint32_t version;
    uint64_t headerChecksum;  ///< of the members below
    uint64_t arraysChecksum;
    SceneHash sceneHash;
    uint64_t scenePrimitives;  ///< it was built over, all places counted
    uint64_t nodeTexels;
    uint64_t triangleTexels;
    uint64_t bottoms;         ///< 0: there is one level
    uint32_t instances;       ///< Structure::instances
    uint32_t leastTriangles;  ///< PlacedScene::leastTriangles; 0: it was built over a scene written out
    std::array<char, 32> structure;
    std::array<char, 48> walk;
    std::array<char, 192> options;
    StructureHeader header;
    uint64_t nodes, leaves, depth, references;
    double sahCost, seconds;
};
static_assert(sizeof(StructureFileHeader) == 472, "nothing in them is padding");

/// A line of the table of bottoms: a Bottom.
struct StructureFileBottom {
    uint64_t mesh;
    uint64_t firstReference;
    uint64_t references;
};

/// Writes `structure`, which was built over `primitives` with `params`, whole or not at all. Throws inputError if that
/// fails.
void saveStructure(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
                   std::span<const Primitive> primitives);
/// The same of what buildTwoLevels made over `scene`, of two levels or one.
void saveStructure(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
                   const PlacedScene& scene);

/// A file of saveStructure. All that is wrong with it is an inputError, which says what to do.
class StructureFile {
public:
    /// Opens the file and checks all but the arrays: so a wrong one is known before a large scene is read.
    explicit StructureFile(const std::filesystem::path& path);

    std::string structureName() const;
    /// As describeOptions gave them.
    std::string options() const;
    /// What building took, in seconds.
    double buildSeconds() const { return header_.seconds; }
    /// The PlacedScene::leastTriangles with which to read it; 0: it was built over a scene written out.
    uint32_t leastTriangles() const { return header_.leastTriangles; }

    /// Reads the structure, once. Throws, too, if it was built over other primitives. Cost O(references), in parallel in
    /// part.
    Structure read(std::span<const Primitive> primitives);
    /// The same of one that was built over a scene kept as instances. Cost as findTwoLevelFault's.
    Structure read(const PlacedScene& scene);

private:
    Error broken(std::string_view what) const;
    void checkHeader() const;
    void checkSizes() const;
    void checkScene(uint32_t leastTriangles, uint64_t primitives, const SceneHash& hash) const;
    Structure readUnchecked();
    Structure checked(Structure structure, const std::optional<std::string>& fault) const;

    InputFile file_;
    StructureFileHeader header_;
};

}  // namespace raig

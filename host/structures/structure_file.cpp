#include "structures/structure_file.hpp"

#include "base/files.hpp"
#include "structures/structure_fault.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace raig {

namespace {

// Not text, and changed by whatever treats it as text.
constexpr std::array<char, 8> magic = {'\x89', 'r', 'a', 'i', 'g', '\r', '\n', '\x1a'};
constexpr uint32_t byteOrderMark = 0x01020304;
constexpr uint32_t otherByteOrderMark = 0x04030201;
// To be raised when the format changes, or what the bytes of a structure mean.
constexpr uint32_t formatVersion = 3;

template <size_t size>
void setName(std::array<char, size>& name, std::string_view text) {
    RAIG_CHECK_OP(text.size(), <, size);
    name.fill('\0');
    std::copy(text.begin(), text.end(), name.begin());
}

template <size_t size>
std::string_view nameOf(const std::array<char, size>& name) {
    return {name.data(), static_cast<size_t>(std::find(name.begin(), name.end(), '\0') - name.begin())};
}

/// True for what setName writes: it is printed.
template <size_t size>
bool isName(const std::array<char, size>& name) {
    const size_t length = nameOf(name).size();
    return length < size && std::all_of(name.begin(), name.begin() + length, [](char c) { return c >= ' ' && c <= '~'; });
}

uint64_t checksumOf(const StructureFileHeader& header) {
    constexpr size_t start = offsetof(StructureFileHeader, arraysChecksum);
    return XXH3_64bits(reinterpret_cast<const char*>(&header) + start, sizeof header - start);
}

std::span<const std::byte> bytesOf(const std::vector<uvec4>& texels) {
    return std::as_bytes(std::span(texels));
}

/// Of all that follows the header.
uint64_t checksumOf(std::span<const StructureFileBottom> bottoms, const std::vector<uvec4>& nodes,
                    const std::vector<uvec4>& triangles) {
    uint64_t sum = XXH3_64bits(bottoms.data(), bottoms.size_bytes());
    for (const std::span<const std::byte> bytes : {bytesOf(nodes), bytesOf(triangles)})
        sum = XXH3_64bits_withSeed(bytes.data(), bytes.size(), sum);
    return sum;
}

/// `header` has what tells the scene.
void save(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
          StructureFileHeader header) {
    std::vector<StructureFileBottom> bottoms;
    for (const Bottom& bottom : structure.bottoms)
        bottoms.push_back({bottom.mesh, bottom.firstReference, bottom.references});
    header.magic = magic;
    header.byteOrder = byteOrderMark;
    header.version = formatVersion;
    header.nodeTexels = structure.nodes.size();
    header.triangleTexels = structure.triangles.size();
    header.bottoms = bottoms.size();
    header.instances = structure.instances;
    setName(header.structure, structure.name);
    setName(header.walk, structure.walk);
    setName(header.options, describeOptions(params));
    header.header = structure.header;
    const StructureStatistics& statistics = structure.statistics;
    header.nodes = statistics.nodes;
    header.leaves = statistics.leaves;
    header.depth = statistics.depth;
    header.references = statistics.references;
    header.sahCost = statistics.sahCost;
    header.seconds = statistics.seconds;
    header.arraysChecksum = checksumOf(bottoms, structure.nodes, structure.triangles);
    header.headerChecksum = checksumOf(header);
    const std::span<const std::byte> pieces[] = {std::as_bytes(std::span(&header, 1)), std::as_bytes(std::span(bottoms)),
                                                 bytesOf(structure.nodes), bytesOf(structure.triangles)};
    writeFileAtomically(path, pieces);
}

}  // namespace

void saveStructure(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
                   std::span<const Primitive> primitives) {
    StructureFileHeader header{};
    header.sceneHash = hashOf(primitives);
    header.scenePrimitives = primitives.size();
    save(path, structure, params, header);
}

void saveStructure(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
                   const PlacedScene& scene) {
    StructureFileHeader header{};
    header.sceneHash = hashOf(scene);
    header.scenePrimitives = primitiveCount(scene);
    header.leastTriangles = scene.leastTriangles;
    save(path, structure, params, header);
}

StructureFile::StructureFile(const std::filesystem::path& path) : file_(path), header_{} {
    const size_t length = std::min<uint64_t>(file_.size(), sizeof header_);
    file_.read(std::as_writable_bytes(std::span(&header_, 1)).first(length));
    if (length == 0 || std::memcmp(header_.magic.data(), magic.data(), std::min(length, magic.size())) != 0)
        throw inputError(path, "is no structure of raig; name a file that --save-structure wrote");
    if (length < sizeof header_) throw broken(fmt::format("has only {} bytes", length));
    checkHeader();
}

Error StructureFile::broken(std::string_view what) const {
    return inputError(file_.path(), "{}; write it again with --save-structure", what);
}

void StructureFile::checkHeader() const {
    if (header_.byteOrder == otherByteOrderMark) throw broken("comes from a machine with the other byte order");
    if (header_.byteOrder != byteOrderMark) throw broken("is damaged: its mark of byte order is none");
    if (header_.version != formatVersion)
        throw broken(fmt::format("is of version {}, and this raig reads version {}", header_.version, formatVersion));
    if (header_.headerChecksum != checksumOf(header_)) throw broken("is damaged: its header has another checksum");
    if (!isName(header_.structure) || !isName(header_.walk) || !isName(header_.options))
        throw broken("is damaged: its names are none");
    checkSizes();
    if (header_.leastTriangles == 0 && (header_.bottoms != 0 || header_.instances != 0))
        throw broken("is damaged: it has instances, and is of a scene written out");
    const auto isAmount = [](double number) { return std::isfinite(number) && number >= 0.0; };
    if (header_.depth > 0xffffffffu || !isAmount(header_.sahCost) || !isAmount(header_.seconds))
        throw broken("is damaged: its statistics are none");
    const auto types = structureTypes();
    if (std::none_of(types.begin(), types.end(), [&](const StructureType& type) { return type.name == structureName(); }))
        throw broken(fmt::format("holds a structure that this raig does not have, {}", structureName()));
}

void StructureFile::checkSizes() const {
    uint64_t left = file_.size() - sizeof header_;
    bool fits = header_.bottoms <= left / sizeof(StructureFileBottom);
    if (fits) left -= header_.bottoms * sizeof(StructureFileBottom);
    const uint64_t texels = left / sizeof(uvec4);  // each size is at most that: their sum does not overflow
    fits = fits && header_.nodeTexels <= texels && header_.triangleTexels <= texels &&
           left == (header_.nodeTexels + header_.triangleTexels) * sizeof(uvec4);
    if (!fits)
        throw broken(fmt::format("has {} bytes, not those of {} texels and {} bottoms", file_.size(),
                                 double(header_.nodeTexels) + double(header_.triangleTexels), header_.bottoms));
}

std::string StructureFile::structureName() const {
    return std::string(nameOf(header_.structure));
}

std::string StructureFile::options() const {
    return std::string(nameOf(header_.options));
}

void StructureFile::checkScene(uint32_t leastTriangles, uint64_t primitives, const SceneHash& hash) const {
    if (header_.leastTriangles != leastTriangles || header_.scenePrimitives != primitives || header_.sceneHash != hash)
        throw broken(
            fmt::format("is of another scene, or of another version of it ({} triangles and spheres; this one has {})",
                        header_.scenePrimitives, primitives));
}

Structure StructureFile::readUnchecked() {
    std::vector<StructureFileBottom> bottoms(header_.bottoms);
    Structure structure;
    structure.name = structureName();
    structure.walk = nameOf(header_.walk);
    structure.header = header_.header;
    structure.nodes.resize(header_.nodeTexels);
    structure.triangles.resize(header_.triangleTexels);
    structure.instances = header_.instances;
    file_.read(std::as_writable_bytes(std::span(bottoms)));
    file_.read(std::as_writable_bytes(std::span(structure.nodes)));
    file_.read(std::as_writable_bytes(std::span(structure.triangles)));
    if (header_.arraysChecksum != checksumOf(bottoms, structure.nodes, structure.triangles))
        throw broken("is damaged: its arrays have another checksum");
    for (const StructureFileBottom& bottom : bottoms) {
        if (bottom.mesh > Bottom::writtenOut) throw broken("is damaged: its table of bottoms names no mesh");
        structure.bottoms.push_back({static_cast<uint32_t>(bottom.mesh), bottom.firstReference, bottom.references});
    }
    StructureStatistics& statistics = structure.statistics;
    statistics.nodes = header_.nodes;
    statistics.leaves = header_.leaves;
    statistics.depth = static_cast<uint32_t>(header_.depth);
    statistics.references = header_.references;
    statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    statistics.sahCost = header_.sahCost;
    statistics.seconds = header_.seconds;
    return structure;
}

Structure StructureFile::checked(Structure structure, const std::optional<std::string>& fault) const {
    if (fault) throw broken(fmt::format("holds a structure that is broken: {}", *fault));
    for (size_t i = 0; i < structure.triangles.size(); i += shared::TRIANGLE_STRIDE)
        structure.triangles[i + 1].w &= shared::TRIANGLE_SPHERE;
    return structure;
}

Structure StructureFile::read(std::span<const Primitive> primitives) {
    checkScene(0, primitives.size(), hashOf(primitives));
    Structure structure = readUnchecked();
    const auto fault = findOneLevelFault(structure, primitives, structureType(structure.name));
    return checked(std::move(structure), fault);
}

Structure StructureFile::read(const PlacedScene& scene) {
    checkScene(scene.leastTriangles, primitiveCount(scene), hashOf(scene));
    Structure structure = readUnchecked();
    const auto fault = findTwoLevelFault(structure, scene, structureType(structure.name));
    return checked(std::move(structure), fault);
}

}  // namespace raig

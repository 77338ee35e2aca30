#include "structures/structure_file.hpp"

#include "base/files.hpp"
#include "structures/structure_fault.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace raig {

namespace {

// Not text, and changed by whatever treats it as text.
constexpr std::array<char, 8> magic = {'\x89', 'r', 'a', 'i', 'g', '\r', '\n', '\x1a'};
constexpr uint32_t byteOrderMark = 0x01020304;
constexpr uint32_t otherByteOrderMark = 0x04030201;
// To be raised when the format changes, or what the bytes of a structure mean.
constexpr uint32_t formatVersion = 2;

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

uint64_t checksumOf(const std::vector<uvec4>& nodes, const std::vector<uvec4>& triangles) {
    const size_t bytes = nodes.size() * sizeof(uvec4);
    return XXH3_64bits_withSeed(triangles.data(), triangles.size() * sizeof(uvec4), XXH3_64bits(nodes.data(), bytes));
}

std::array<uint64_t, 2> hashOf(std::span<const Primitive> triangles) {
    const XXH128_hash_t hash = XXH3_128bits(triangles.data(), triangles.size_bytes());
    return {hash.low64, hash.high64};
}

std::span<const std::byte> bytesOf(const std::vector<uvec4>& texels) {
    return std::as_bytes(std::span(texels));
}

}  // namespace

void saveStructure(const std::filesystem::path& path, const Structure& structure, const BuildParams& params,
                   std::span<const Primitive> triangles) {
    StructureFileHeader header{};
    header.magic = magic;
    header.byteOrder = byteOrderMark;
    header.version = formatVersion;
    header.geometryHash = hashOf(triangles);
    header.sceneTriangles = triangles.size();
    header.nodeTexels = structure.nodes.size();
    header.triangleTexels = structure.triangles.size();
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
    header.arraysChecksum = checksumOf(structure.nodes, structure.triangles);
    header.headerChecksum = checksumOf(header);
    const std::span<const std::byte> pieces[] = {std::as_bytes(std::span(&header, 1)), bytesOf(structure.nodes),
                                                 bytesOf(structure.triangles)};
    writeFileAtomically(path, pieces);
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
    const uint64_t texels =
        (file_.size() - sizeof header_) / sizeof(uvec4);  // both sizes are at most that: no sum overflows
    if (header_.nodeTexels > texels || header_.triangleTexels > texels ||
        file_.size() != sizeof header_ + (header_.nodeTexels + header_.triangleTexels) * sizeof(uvec4))
        throw broken(fmt::format("has {} bytes, not those of {} texels", file_.size(),
                                 double(header_.nodeTexels) + double(header_.triangleTexels)));
    const auto types = structureTypes();
    if (std::none_of(types.begin(), types.end(), [&](const StructureType& type) { return type.name == structureName(); }))
        throw broken(fmt::format("holds a structure that this raig does not have, {}", structureName()));
}

std::string StructureFile::structureName() const {
    return std::string(nameOf(header_.structure));
}

std::string StructureFile::options() const {
    return std::string(nameOf(header_.options));
}

Structure StructureFile::read(std::span<const Primitive> triangles) {
    if (header_.sceneTriangles != triangles.size() || header_.geometryHash != hashOf(triangles))
        throw broken(fmt::format("is of another scene, or of another version of it ({} triangles; this one has {})",
                                 header_.sceneTriangles, triangles.size()));
    Structure structure;
    structure.name = structureName();
    structure.walk = nameOf(header_.walk);
    structure.header = header_.header;
    structure.nodes.resize(header_.nodeTexels);
    structure.triangles.resize(header_.triangleTexels);
    file_.read(std::as_writable_bytes(std::span(structure.nodes)));
    file_.read(std::as_writable_bytes(std::span(structure.triangles)));
    if (header_.arraysChecksum != checksumOf(structure.nodes, structure.triangles))
        throw broken("is damaged: its arrays have another checksum");

    const std::optional<std::string> fault = findOneLevelFault(structure, triangles, structureType(structure.name));
    if (fault) throw broken(fmt::format("holds a structure that is broken: {}", *fault));

    StructureStatistics& statistics = structure.statistics;
    statistics.nodes = header_.nodes;
    statistics.leaves = header_.leaves;
    statistics.depth = static_cast<uint32_t>(header_.depth);
    statistics.references = header_.references;
    statistics.bytes = (structure.nodes.size() + structure.triangles.size()) * sizeof(uvec4);
    statistics.sahCost = header_.sahCost;
    statistics.seconds = header_.seconds;
    for (size_t i = 0; i < structure.triangles.size(); i += shared::TRIANGLE_STRIDE)
        structure.triangles[i + 1].w &= shared::TRIANGLE_SPHERE;
    return structure;
}

}  // namespace raig

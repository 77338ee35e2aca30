#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/import.hpp"
#include "scene/text.hpp"

#include <bit>
#include <cstring>

namespace raig {

namespace {

constexpr size_t headerSize = 84;  ///< 80 bytes of anything, then the number of facets
constexpr size_t facetSize = 50;   ///< normal and three corners of 12 bytes each, and 2 bytes of attributes

uint32_t littleEndian32(const std::byte* bytes) {
    const auto b = [&](int i) { return static_cast<uint32_t>(bytes[i]) << (8 * i); };
    return b(0) | b(1) | b(2) | b(3);
}

vec3 readPoint(const std::byte* bytes) {
    return {std::bit_cast<float>(littleEndian32(bytes)), std::bit_cast<float>(littleEndian32(bytes + 4)),
            std::bit_cast<float>(littleEndian32(bytes + 8))};
}

void addTriangle(Mesh& mesh, const vec3& a, const vec3& b, const vec3& c) {
    if (mesh.positions.size() > 0xfffffffc) throw limitError("{}: more than {} corners", mesh.name, 0xffffffff);
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    mesh.triangles.emplace_back(first, first + 1, first + 2);
    mesh.materials.push_back(0);
}

void readBinary(std::span<const std::byte> bytes, Mesh& mesh) {
    const size_t facets = (bytes.size() - headerSize) / facetSize;
    mesh.positions.reserve(3 * facets);
    mesh.triangles.reserve(facets);
    mesh.materials.reserve(facets);
    for (size_t i = 0; i < facets; ++i) {
        const std::byte* corners = bytes.data() + headerSize + i * facetSize + 12;
        addTriangle(mesh, readPoint(corners), readPoint(corners + 12), readPoint(corners + 24));
    }
}

/// Reads one or more "solid ... endsolid", keywords in any case.
class AsciiReader {
public:
    AsciiReader(std::string_view text, std::string file, Scene& scene)
        : words_(text), file_(std::move(file)), scene_(scene), mesh_(scene.meshes.front()) {}

    void read() {
        std::string_view word = words_.next();
        while (!word.empty()) {
            check(word, "solid");
            words_.skipLine();  // the name, which may be any words
            for (word = words_.next(); text::equalsIgnoringCase(word, "facet"); word = words_.next()) readFacet();
            check(word, "endsolid");
            words_.skipLine();
            word = words_.next();
        }
    }

private:
    void check(std::string_view word, std::string_view expected) const {
        if (text::equalsIgnoringCase(word, expected)) return;
        if (word.empty()) throw inputError(file_, "ends where '{}' should follow: the file is cut off", expected);
        throw inputError(fmt::format("{}:{}", file_, words_.line()), "{} where '{}' should stand", text::quoted(word),
                         expected);
    }

    float readCoordinate() {
        const std::string_view word = words_.next();
        const auto value = text::parseFloat(word);
        if (!value && word.empty()) throw inputError(file_, "ends inside a vertex: the file is cut off");
        if (!value) throw inputError(fmt::format("{}:{}", file_, words_.line()), "{} is not a number", text::quoted(word));
        return *value;
    }

    /// A facet of more than three corners is fanned; one of fewer is counted. The normal is the corners' business.
    void readFacet() {
        words_.skipLine();
        check(words_.next(), "outer");
        check(words_.next(), "loop");
        vec3 first{}, before{};
        size_t corners = 0;
        std::string_view word = words_.next();
        for (; text::equalsIgnoringCase(word, "vertex"); word = words_.next(), ++corners) {
            vec3 corner;
            corner.x = readCoordinate();
            corner.y = readCoordinate();
            corner.z = readCoordinate();
            if (corners == 0) first = corner;
            if (corners >= 2) addTriangle(mesh_, first, before, corner);
            before = corner;
        }
        check(word, "endloop");
        check(words_.next(), "endfacet");
        if (corners < 3) ++scene_.otherPrimitives;
    }

    text::Words words_;
    std::string file_;
    Scene& scene_;
    Mesh& mesh_;
};

bool startsLikeAscii(std::span<const std::byte> bytes) {
    const std::string_view start(reinterpret_cast<const char*>(bytes.data()), std::min<size_t>(bytes.size(), headerSize));
    std::string_view text = start;
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    return text::equalsIgnoringCase(text::trimmed(text).substr(0, 5), "solid") && start.find('\0') == std::string_view::npos;
}

}  // namespace

Scene importStl(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = readFile(path);
    Scene scene;
    scene.meshes.push_back({});
    scene.meshes.front().name = path.filename();
    scene.instances.push_back({});
    scene.materials.push_back({});

    // Binary files may begin with "solid" too: the size, which follows from the number of facets, tells them apart.
    const uint64_t facets = bytes.size() >= headerSize ? littleEndian32(bytes.data() + headerSize - 4) : 0;
    const uint64_t binarySize = headerSize + facets * facetSize;
    if (bytes.size() >= headerSize && bytes.size() == binarySize) {
        readBinary(bytes, scene.meshes.front());
    } else if (startsLikeAscii(bytes)) {
        AsciiReader(text::checkText(bytes, path), path, scene).read();
    } else if (bytes.size() < headerSize) {
        throw inputError(path, "is no STL file: it neither begins with 'solid' nor has the 84 bytes of a binary header");
    } else {
        throw inputError(path, "announces {} facets, which take {} bytes, but holds {} bytes: cut off or damaged", facets,
                         binarySize, bytes.size());
    }
    return scene;
}

}  // namespace raig

#include "scene/obj.hpp"

#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/color.hpp"
#include "scene/import.hpp"
#include "scene/text.hpp"

#include <array>
#include <limits>
#include <unordered_map>

namespace raig {

namespace {

constexpr uint32_t absent = 0xffffffff;
constexpr size_t mostEntries = 0x7fffffff;

enum Kind : size_t { position = 0, uv = 1, normal = 2 };
constexpr std::array<std::string_view, 3> statementOf{"v", "vt", "vn"};

/// What one corner of a face names, in the order of its text: v/vt/vn.
using Corner = std::array<uint32_t, 3>;

/// The statements of an OBJ file as they stand, indices resolved to count from 0.
struct ObjFile {
    std::vector<vec3> positions, normals, colors;
    std::vector<vec2> uvs;
    std::vector<Corner> corners;
    std::vector<size_t> faceEnds;            ///< of each face of at least 3 corners, in `corners`
    std::vector<uint32_t> faceMaterials;     ///< an index into materialNames
    std::vector<std::string> materialNames;  ///< in order of first use by a face; "" before any usemtl
    std::vector<std::string> libraries;
    uint64_t otherPrimitives = 0;
    size_t unknownStatements = 0;
    std::string firstUnknown;
};

class Reader {
public:
    Reader(std::string_view text, std::string file) : statements_(text), file_(std::move(file)) {}

    ObjFile read();

private:
    [[nodiscard]] std::string place() const { return fmt::format("{}:{}", file_, statements_.line()); }
    size_t count(Kind kind) const {
        return kind == position ? s_.positions.size() : kind == uv ? s_.uvs.size() : s_.normals.size();
    }

    void readOne(text::Words& words);
    size_t readNumbers(text::Words& words, std::span<float> numbers, size_t least, std::string_view what);
    void readPosition(text::Words& words);
    void readFace(text::Words& words);
    Corner readCorner(std::string_view word);
    uint32_t readIndex(std::string_view digits, std::string_view word, Kind kind);
    uint32_t currentMaterial();
    void checkForwardReferences() const;

    text::Statements statements_;
    std::string file_;
    ObjFile s_;
    std::string materialName_;
    uint32_t material_ = absent;
    std::unordered_map<std::string, uint32_t> materialIndices_;
    /// Faces may name what only later lines define, so the largest index is kept with its line and checked at the end.
    struct Farthest {
        uint32_t index = 0;
        size_t line = 0;
    };
    std::array<Farthest, 3> farthest_;
};

ObjFile Reader::read() {
    while (const auto statement = statements_.next()) {
        text::Words words(*statement);
        readOne(words);
    }
    checkForwardReferences();
    return std::move(s_);
}

bool hasNoEffect(std::string_view key) {
    return key.empty() || key.front() == '#' || key == "g" || key == "o" || key == "s" || key == "mg" || key == "vp" ||
           key == "lod" || key == "bevel" || key == "c_interp" || key == "d_interp" || key == "shadow_obj" ||
           key == "trace_obj" || key == "usemap" || key == "maplib";
}

void Reader::readOne(text::Words& words) {
    const std::string_view key = words.next();
    std::array<float, 3> numbers{};
    if (key == "v") {
        readPosition(words);
    } else if (key == "vt") {
        readNumbers(words, numbers, 1, "vt u v");
        s_.uvs.emplace_back(numbers[0], 1.0f - numbers[1]);
    } else if (key == "vn") {
        readNumbers(words, numbers, 3, "vn x y z");
        s_.normals.emplace_back(numbers[0], numbers[1], numbers[2]);
    } else if (key == "f" || key == "fo") {
        readFace(words);
    } else if (key == "usemtl") {
        materialName_ = words.rest();
        material_ = absent;
    } else if (key == "mtllib") {
        s_.libraries.emplace_back(words.rest());
    } else if (key == "l") {
        ++s_.otherPrimitives;
    } else if (key == "p") {
        while (!words.next().empty()) ++s_.otherPrimitives;
    } else if (!hasNoEffect(key)) {
        if (s_.unknownStatements++ == 0) s_.firstUnknown = fmt::format("{}: {}", place(), text::quoted(key));
    }
}

/// Reads all words of the statement (up to a comment) as numbers. Returns how many there are: at least `least`, at most as
/// many as `numbers` holds; further ones are checked and dropped.
size_t Reader::readNumbers(text::Words& words, std::span<float> numbers, size_t least, std::string_view what) {
    size_t found = 0;
    for (std::string_view word = words.next(); !word.empty() && word.front() != '#'; word = words.next()) {
        const auto value = text::parseFloat(word);
        if (!value) throw inputError(place(), "{} is not a number (expected: {})", text::quoted(word), what);
        if (found < numbers.size()) numbers[found++] = *value;
    }
    if (found < least)
        throw inputError(place(), "{} numbers where at least {} are needed (expected: {})", found, least, what);
    return found;
}

/// x y z, x y z w, x y z r g b, or x y z w r g b.
void Reader::readPosition(text::Words& words) {
    std::array<float, 7> n{};
    const size_t found = readNumbers(words, n, 3, "v x y z");
    if (s_.positions.size() >= mostEntries) throw limitError("{}: more than {} vertices", place(), mostEntries);
    s_.positions.emplace_back(n[0], n[1], n[2]);
    if (found < 6 && s_.colors.empty()) return;
    s_.colors.resize(s_.positions.size() - 1, vec3(1.0f));
    const size_t red = found == 7 ? 4 : 3;
    const vec3 color = found < 6 ? vec3(1.0f) : vec3(n[red], n[red + 1], n[red + 2]);
    s_.colors.push_back(isFinite(color) ? linearFromSrgb(color) : vec3(1.0f));
}

void Reader::readFace(text::Words& words) {
    const size_t begin = s_.corners.size();
    for (std::string_view word = words.next(); !word.empty() && word.front() != '#'; word = words.next())
        s_.corners.push_back(readCorner(word));
    if (s_.corners.size() - begin < 3) {
        s_.corners.resize(begin);
        ++s_.otherPrimitives;
        return;
    }
    s_.faceEnds.push_back(s_.corners.size());
    s_.faceMaterials.push_back(currentMaterial());
}

Corner Reader::readCorner(std::string_view word) {
    Corner corner{absent, absent, absent};
    std::string_view left = word;
    for (size_t kind = 0; kind < 3; ++kind) {
        const size_t slash = left.find('/');
        const std::string_view digits = left.substr(0, slash);
        if (!digits.empty() || kind == position) corner[kind] = readIndex(digits, word, static_cast<Kind>(kind));
        if (slash == std::string_view::npos) return corner;
        left.remove_prefix(slash + 1);
    }
    throw inputError(place(), "{} has too many parts for a corner (expected: v, v/vt, v//vn or v/vt/vn)",
                     text::quoted(word));
}

uint32_t Reader::readIndex(std::string_view digits, std::string_view word, Kind kind) {
    const auto written = text::parseInteger(digits);
    const auto known = static_cast<int64_t>(count(kind));
    if (!written || *written == 0)
        throw inputError(place(), "{} is not an index in the corner {} (indices are whole numbers but 0)",
                         text::quoted(digits), text::quoted(word));
    if (*written < -known)
        throw inputError(place(), "the corner {} reaches back {} '{}' statements, of which there are {} before it",
                         text::quoted(word), -*written, statementOf[kind], known);
    if (*written > static_cast<int64_t>(mostEntries))
        throw inputError(place(), "the index {} is far beyond the end of any '{}' list", *written, statementOf[kind]);
    const auto index = static_cast<uint32_t>(*written < 0 ? known + *written : *written - 1);
    if (index >= farthest_[kind].index) farthest_[kind] = {index + 1, statements_.line()};
    return index;
}

uint32_t Reader::currentMaterial() {
    if (material_ == absent) {
        const auto [entry, isNew] =
            materialIndices_.try_emplace(materialName_, static_cast<uint32_t>(s_.materialNames.size()));
        if (isNew) s_.materialNames.push_back(materialName_);
        material_ = entry->second;
    }
    return material_;
}

void Reader::checkForwardReferences() const {
    for (const Kind kind : {position, uv, normal})
        if (farthest_[kind].index > count(kind))
            throw inputError(fmt::format("{}:{}", file_, farthest_[kind].line),
                             "index {} is beyond the {} '{}' statements of the file", farthest_[kind].index, count(kind),
                             statementOf[kind]);
}

/// Makes one vertex of each distinct corner. Corners of one position form a list, which is short in any sane mesh; a
/// position that a hostile file gives many partners would make it quadratic, so a list's length is bounded and what
/// lies beyond gets a vertex of its own.
class Welder {
public:
    explicit Welder(const ObjFile& s) : s_(s), firstOf_(s.positions.size(), absent) {}

    uint32_t vertex(const Corner& corner) {
        uint32_t at = firstOf_[corner[position]];
        for (int tries = 0; at != absent && tries < 64; ++tries, at = nextOf_[at])
            if (corners_[at] == corner) return at;
        if (corners_.size() >= absent) throw limitError("more than {} different vertices", absent - 1);
        const auto added = static_cast<uint32_t>(corners_.size());
        corners_.push_back(corner);
        nextOf_.push_back(firstOf_[corner[position]]);
        firstOf_[corner[position]] = added;
        return added;
    }

    /// Moves the vertices into `mesh`. True if a normal, uv or colour had to be replaced.
    bool fill(Mesh& mesh) const;

private:
    const ObjFile& s_;
    std::vector<uint32_t> firstOf_, nextOf_;
    std::vector<Corner> corners_;
};

bool Welder::fill(Mesh& mesh) const {
    bool anyUv = false, anyNormal = false, replaced = false;
    for (const Corner& corner : corners_) {
        anyUv |= corner[uv] != absent;
        anyNormal |= corner[normal] != absent;
    }
    mesh.positions.reserve(corners_.size());
    for (const Corner& corner : corners_) {
        mesh.positions.push_back(s_.positions[corner[position]]);
        if (!s_.colors.empty())
            mesh.colors.push_back(corner[position] < s_.colors.size() ? s_.colors[corner[position]] : vec3(1.0f));
        if (anyUv) {
            const vec2 at = corner[uv] == absent ? vec2(0.0f) : s_.uvs[corner[uv]];
            replaced |= !isUsableUv(at);
            mesh.uvs.push_back(isUsableUv(at) ? at : vec2(0.0f));
        }
        if (anyNormal) {
            const dvec3 n = corner[normal] == absent ? dvec3(0.0) : dvec3(s_.normals[corner[normal]]);
            const double length = glm::length(n);
            const bool sound = std::isfinite(length);
            replaced |= !sound;
            mesh.normals.push_back(sound && length > 0.0 ? vec3(n / length) : vec3(0.0f));
        }
    }
    return replaced;
}

Mesh buildMesh(const ObjFile& s, const std::string& name, std::vector<std::string>& remarks) {
    Mesh mesh;
    mesh.name = name;
    Welder welder(s);
    const size_t triangles = s.corners.size() - 2 * s.faceEnds.size();
    mesh.triangles.reserve(triangles);
    mesh.materials.reserve(triangles);
    size_t begin = 0;
    for (size_t face = 0; face < s.faceEnds.size(); ++face) {
        const uint32_t first = welder.vertex(s.corners[begin]);
        uint32_t before = welder.vertex(s.corners[begin + 1]);
        for (size_t i = begin + 2; i < s.faceEnds[face]; ++i) {
            const uint32_t last = welder.vertex(s.corners[i]);
            mesh.triangles.emplace_back(first, before, last);
            mesh.materials.push_back(s.faceMaterials[face]);
            before = last;
        }
        begin = s.faceEnds[face];
    }
    if (welder.fill(mesh))
        remarks.push_back(fmt::format("{}: normals or texture coordinates that are no numbers are left out", name));
    return mesh;
}

}  // namespace

Scene importObj(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = readFile(path);
    ObjFile file = Reader(text::checkText(bytes, path), path).read();

    Scene scene;
    scene.otherPrimitives = file.otherPrimitives;
    if (file.unknownStatements > 0)
        scene.remarks.push_back(fmt::format("{} statements of unknown kind left out, the first at {}",
                                            file.unknownStatements, file.firstUnknown));
    scene.meshes.push_back(buildMesh(file, path.filename(), scene.remarks));
    scene.instances.push_back({});
    if (file.materialNames.empty()) file.materialNames.emplace_back();
    addMtlMaterials(scene, path.parent_path(), file.libraries, file.materialNames);
    return scene;
}

}  // namespace raig

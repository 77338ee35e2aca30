#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/color.hpp"
#include "scene/import.hpp"
#include "scene/ply_header.hpp"
#include "scene/text.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>

namespace raig {

namespace {

using namespace ply;

/// Values of a binary body, one after the other.
class BinaryBody {
public:
    BinaryBody(std::span<const std::byte> bytes, const Header& header, std::string file)
        : left_(bytes),
          swaps_((header.encoding == Encoding::binaryBigEndian) == (std::endian::native == std::endian::little)),
          file_(std::move(file)) {}

    size_t left() const { return left_.size(); }
    static size_t leastSize(Type type) { return sizeOf(type); }
    std::string place(const Element& element, uint64_t entry) const {
        return fmt::format("{}: {} {}", file_, element.name, entry);
    }

    double read(Type type, const Element& element, uint64_t entry) {
        std::array<std::byte, 8> raw{};
        const size_t size = sizeOf(type);
        if (left_.size() < size) throw inputError(place(element, entry), "the file ends inside it: cut off");
        std::memcpy(raw.data(), left_.data(), size);
        left_ = left_.subspan(size);
        if (swaps_) std::reverse(raw.data(), raw.data() + size);
        switch (type) {
            case Type::int8:
                return as<int8_t>(raw);
            case Type::uint8:
                return as<uint8_t>(raw);
            case Type::int16:
                return as<int16_t>(raw);
            case Type::uint16:
                return as<uint16_t>(raw);
            case Type::int32:
                return as<int32_t>(raw);
            case Type::uint32:
                return as<uint32_t>(raw);
            case Type::float32:
                return as<float>(raw);
            case Type::float64:
                break;
        }
        return as<double>(raw);
    }

private:
    template <class T>
    static double as(const std::array<std::byte, 8>& raw) {
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return static_cast<double>(value);
    }

    std::span<const std::byte> left_;
    bool swaps_;
    std::string file_;
};

/// Words of an ASCII body; where lines end does not matter.
class AsciiBody {
public:
    AsciiBody(std::string_view text, const Header& header, std::string file)
        : words_(text, header.bodyLine), file_(std::move(file)) {}

    /// A value and the blank after it take two characters; the last one has no blank.
    size_t left() const { return words_.charactersLeft() + 1; }
    static size_t leastSize(Type) { return 2; }
    std::string place(const Element&, uint64_t) const { return fmt::format("{}:{}", file_, words_.line()); }

    double read(Type type, const Element& element, uint64_t entry) {
        const std::string_view word = words_.next();
        if (word.empty()) throw inputError(file_, "ends inside {} {}: cut off", element.name, entry);
        if (isInteger(type)) {
            if (const auto value = text::parseInteger(word)) return static_cast<double>(*value);
        } else if (const auto value = text::parseFloat(word)) {
            return *value;
        }
        throw inputError(place(element, entry), "{} is no {}", text::quoted(word),
                         isInteger(type) ? "whole number" : "number");
    }

private:
    text::Words words_;
    std::string file_;
};

/// Where the properties of a vertex go.
enum Slot : size_t { x, y, z, nx, ny, nz, u, v, red, green, blue, slotCount };

size_t slotOf(const Property& property) {
    static constexpr std::array<std::array<std::string_view, 4>, slotCount> names{{{"x"},
                                                                                   {"y"},
                                                                                   {"z"},
                                                                                   {"nx"},
                                                                                   {"ny"},
                                                                                   {"nz"},
                                                                                   {"u", "s", "texture_u", "texture_s"},
                                                                                   {"v", "t", "texture_v", "texture_t"},
                                                                                   {"red", "r", "diffuse_red"},
                                                                                   {"green", "g", "diffuse_green"},
                                                                                   {"blue", "b", "diffuse_blue"}}};
    if (!property.isList)
        for (size_t slot = 0; slot < slotCount; ++slot)
            if (std::ranges::find(names[slot], property.name) != names[slot].end()) return slot;
    return slotCount;
}

/// Integers are sRGB-encoded fractions of their type's largest value; floats are linear. What is out of range is clamped.
float decodeColor(double value, Type type) {
    if (!isInteger(type))
        return value > 0.0 ? static_cast<float>(std::min<double>(value, std::numeric_limits<float>::max())) : 0.0f;
    const size_t bits = 8 * sizeOf(type) - (type == Type::int8 || type == Type::int16 || type == Type::int32 ? 1 : 0);
    return linearFromSrgb(static_cast<float>(value / (std::exp2(static_cast<double>(bits)) - 1.0)));
}

template <class Body>
class BodyReader {
public:
    BodyReader(Body body, const Header& header, std::string file, Scene& scene)
        : body_(std::move(body)), header_(header), file_(std::move(file)), scene_(scene), mesh_(scene.meshes.front()) {}

    void read() {
        for (const Element& element : header_.elements)
            if (element.name == "vertex") vertexCount_ = element.count;
        for (const Element& element : header_.elements) {
            checkCount(element);
            if (element.name == "vertex")
                readVertices(element);
            else if (element.name == "face")
                readFaces(element);
            else
                skip(element);
        }
    }

private:
    /// Refuses, before anything is allocated, what announces more than the file can hold.
    void checkCount(const Element& element) const {
        const size_t least = leastSize(element, header_.encoding);
        if (least > 0 && element.count > body_.left() / least)
            throw inputError(file_,
                             "announces {} entries of {}, more than the {} bytes that are left can hold: cut off or damaged",
                             element.count, text::quoted(element.name), body_.left());
    }

    uint64_t readLength(const Property& property, const Element& element, uint64_t entry) {
        const double length = body_.read(property.countType, element, entry);
        if (length < 0.0 || length > static_cast<double>(body_.left() / Body::leastSize(property.type)))
            throw inputError(body_.place(element, entry), "announces a list of {} values, more than the file can hold",
                             length);
        return static_cast<uint64_t>(length);
    }

    void skipProperty(const Property& property, const Element& element, uint64_t entry) {
        const uint64_t values = property.isList ? readLength(property, element, entry) : 1;
        for (uint64_t i = 0; i < values; ++i) body_.read(property.type, element, entry);
    }

    void skip(const Element& element) {
        if (element.properties.empty()) return;
        for (uint64_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties) skipProperty(property, element, i);
        if (element.name == "tristrips" || element.name == "edge") {
            scene_.otherPrimitives += element.count;
            scene_.remarks.push_back(fmt::format("{}: {} entries of {} left out: only faces are read", file_, element.count,
                                                 text::quoted(element.name)));
        }
    }

    void readVertices(const Element& element) {
        if (element.count > 0xfffffffe)
            throw limitError("{}: {} vertices, at most {} can be read", file_, element.count, 0xfffffffe);
        std::array<bool, slotCount> has{};
        std::vector<size_t> slots;
        for (const Property& property : element.properties) {
            slots.push_back(slotOf(property));
            if (slots.back() < slotCount) has[slots.back()] = true;
        }
        if (!has[x] || !has[y] || !has[z]) throw inputError(file_, "its vertices have no x, y and z");
        const bool hasNormals = has[nx] && has[ny] && has[nz], hasUvs = has[u] && has[v];
        const bool hasColors = has[red] && has[green] && has[blue];
        mesh_.positions.reserve(element.count);
        if (hasNormals) mesh_.normals.reserve(element.count);
        if (hasUvs) mesh_.uvs.reserve(element.count);
        if (hasColors) mesh_.colors.reserve(element.count);

        for (uint64_t i = 0; i < element.count; ++i) {
            std::array<double, slotCount> value{};
            for (size_t p = 0; p < slots.size(); ++p) {
                const Property& property = element.properties[p];
                if (slots[p] == slotCount)
                    skipProperty(property, element, i);
                else if (slots[p] >= red)
                    value[slots[p]] = decodeColor(body_.read(property.type, element, i), property.type);
                else
                    value[slots[p]] = body_.read(property.type, element, i);
            }
            mesh_.positions.emplace_back(value[x], value[y], value[z]);
            if (hasNormals) addNormal({value[nx], value[ny], value[nz]});
            if (hasUvs) addUv({value[u], 1.0 - value[v]});
            if (hasColors) mesh_.colors.emplace_back(value[red], value[green], value[blue]);
        }
    }

    void addNormal(const dvec3& n) {
        const double length = glm::length(n);
        mesh_.normals.push_back(std::isfinite(length) && length > 0.0 ? vec3(n / length) : vec3(0.0f));
    }

    void addUv(const dvec2& at) {
        const vec2 rounded(at);
        mesh_.uvs.push_back(isUsableUv(rounded) ? rounded : vec2(0.0f));
    }

    void readFaces(const Element& element) {
        size_t list = element.properties.size();
        for (size_t p = 0; p < element.properties.size(); ++p) {
            const Property& property = element.properties[p];
            if (property.isList && isInteger(property.type) &&
                (property.name == "vertex_indices" || property.name == "vertex_index"))
                list = p;
        }
        if (list == element.properties.size() && element.count > 0)
            throw inputError(file_, "its faces have no list of whole numbers named 'vertex_indices' or 'vertex_index'");
        mesh_.triangles.reserve(element.count);
        for (uint64_t i = 0; i < element.count; ++i)
            for (size_t p = 0; p < element.properties.size(); ++p) {
                if (p == list)
                    readCorners(element.properties[p], element, i);
                else
                    skipProperty(element.properties[p], element, i);
            }
    }

    /// Reads one face and fans it from its first corner.
    void readCorners(const Property& property, const Element& element, uint64_t face) {
        const uint64_t corners = readLength(property, element, face);
        if (corners < 3) ++scene_.otherPrimitives;
        uint32_t first = 0, before = 0;
        for (uint64_t i = 0; i < corners; ++i) {
            const double written = body_.read(property.type, element, face);
            if (written < 0.0 || written >= static_cast<double>(vertexCount_))
                throw inputError(body_.place(element, face), "names vertex {}, but there are {} (counted from 0)", written,
                                 vertexCount_);
            const auto corner = static_cast<uint32_t>(written);
            if (i == 0) first = corner;
            if (i >= 2) mesh_.triangles.emplace_back(first, before, corner);
            before = corner;
        }
    }

    Body body_;
    const Header& header_;
    std::string file_;
    Scene& scene_;
    Mesh& mesh_;
    uint64_t vertexCount_ = 0;
};

}  // namespace

Scene importPly(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = readFile(path);
    const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const Header header = readHeader(content, path);

    Scene scene;
    scene.meshes.push_back({});
    Mesh& mesh = scene.meshes.front();
    mesh.name = path.filename();
    scene.instances.push_back({});
    if (header.encoding == Encoding::ascii) {
        BodyReader(AsciiBody(content.substr(header.bodyOffset), header, path), header, path, scene).read();
    } else {
        BodyReader(BinaryBody(std::span<const std::byte>(bytes).subspan(header.bodyOffset), header, path), header, path,
                   scene)
            .read();
    }
    mesh.materials.assign(mesh.triangles.size(), 0);
    if (mesh.triangles.empty()) scene.otherPrimitives += mesh.positions.size();  // a cloud of points
    scene.materials.push_back({});
    if (!mesh.colors.empty()) scene.materials.front().baseColor = vec3(1.0f);
    return scene;
}

}  // namespace raig

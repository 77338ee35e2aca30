/// A glTF asset put together in a test: JSON and bytes, written as a GLB to a file of its own and imported from there.
#pragma once

#include "base/files.hpp"
#include "scene/import.hpp"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <filesystem>
#include <span>

namespace raig::test {

/// A folder that is removed with all in it at the end.
class TemporaryFolder {
public:
    TemporaryFolder() {
        static int count = 0;
        path = std::filesystem::temp_directory_path() /
               ("raig-gltf-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
        std::filesystem::create_directories(path);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    std::filesystem::path path;
};

class GltfAsset {
public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}};

    /// Adds an accessor over `values`, in a buffer view of its own. `type` is "VEC3" and the like.
    template <class T>
    int accessor(const std::vector<T>& values, const std::string& type, int componentType, bool normalized = false) {
        const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<size_t>(type[3] - '0');
        nlohmann::json accessor = {{"bufferView", view(values)},
                                   {"componentType", componentType},
                                   {"type", type},
                                   {"count", values.size() / components}};
        if (normalized) accessor["normalized"] = true;
        json["accessors"].push_back(accessor);
        return static_cast<int>(json["accessors"].size()) - 1;
    }
    int floats(const std::vector<float>& values, const std::string& type) { return accessor(values, type, 5126); }
    int indices(const std::vector<uint16_t>& values) { return accessor(values, "SCALAR", 5123); }

    /// Adds the bytes of `values`, 4-byte aligned, and a buffer view over them.
    template <class T>
    int view(const std::vector<T>& values) {
        while (bytes_.size() % 4) bytes_.push_back(std::byte{0});
        const auto more = std::as_bytes(std::span(values));
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", more.size()}});
        bytes_.insert(bytes_.end(), more.begin(), more.end());
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }

    /// Adds a mesh of one triangle (0,0,0) (1,0,0) (0,1,0), and returns its index.
    int triangle() { return mesh({{"attributes", {{"POSITION", floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}}); }

    int mesh(const nlohmann::json& primitive) {
        json["meshes"].push_back({{"primitives", nlohmann::json::array({primitive})}});
        return static_cast<int>(json["meshes"].size()) - 1;
    }
    int node(const nlohmann::json& node) {
        json["nodes"].push_back(node);
        return static_cast<int>(json["nodes"].size()) - 1;
    }

    std::vector<std::byte> glb() const {
        nlohmann::json whole = json;
        if (!bytes_.empty()) whole["buffers"] = {{{"byteLength", bytes_.size()}}};
        std::string text = whole.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::byte> binary = bytes_;
        binary.resize((binary.size() + 3) / 4 * 4);
        std::vector<std::byte> file;
        const auto word = [&](uint32_t value) {
            for (int i = 0; i < 4; ++i) file.push_back(static_cast<std::byte>(value >> 8 * i & 0xff));
        };
        const auto append = [&](std::span<const std::byte> part) { file.insert(file.end(), part.begin(), part.end()); };
        const size_t binaryChunk = binary.empty() ? 0 : 8 + binary.size();
        word(0x46546c67), word(2), word(static_cast<uint32_t>(20 + text.size() + binaryChunk));
        word(static_cast<uint32_t>(text.size())), word(0x4e4f534a), append(std::as_bytes(std::span(text)));
        if (!binary.empty()) word(static_cast<uint32_t>(binary.size())), word(0x004e4942), append(binary);
        return file;
    }

    Scene load(const Moment& moment = {}) const {
        const TemporaryFolder folder;
        return loadFrom(folder.path, moment);
    }
    Scene loadFrom(const std::filesystem::path& folder, const Moment& moment = {}) const {
        writeFileAtomically(folder / "asset.glb", glb());
        return importGltf(folder / "asset.glb", moment);
    }

private:
    std::vector<std::byte> bytes_;
};

}  // namespace raig::test

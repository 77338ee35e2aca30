/// Files that a test writes, and what the importers make of them.
#pragma once

#include "base/error.hpp"
#include "scene/scene.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace raig {

/// A folder for a test's files, gone with it.
class Folder {
public:
    Folder() {
        // In memory where there is such a place: some tests write thousands of files.
        const std::filesystem::path parent = std::filesystem::exists("/dev/shm") ? "/dev/shm" : testing::TempDir();
        std::string name = (parent / "raig_test_XXXXXX").string();
        if (mkdtemp(name.data()) != nullptr) path_ = name;
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() { std::filesystem::remove_all(path_); }

    std::filesystem::path write(const std::string& name, std::string_view content) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << content;
        return path_ / name;
    }

private:
    std::filesystem::path path_;
};

/// The text of the error that `load` throws; "" if it throws none.
template <class Load>
std::string errorOf(const Load& load) {
    try {
        load();
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::badInput);
        return error.what();
    }
    return "";
}

/// As errorOf for `import` of a file `name` with this content, without the folder in front.
inline std::string refusalOf(Scene (*import)(const std::filesystem::path&), const std::string& name,
                             std::string_view content) {
    const Folder folder;
    const std::filesystem::path path = folder.write(name, content);
    const std::string error = errorOf([&] { import(path); });
    const std::string where = path.parent_path().string() + "/";
    return error.starts_with(where) ? error.substr(where.size()) : error;
}

/// The corners of all triangles, in order.
inline std::vector<vec3> corners(const Scene& scene) {
    std::vector<vec3> points;
    for (const Mesh& mesh : scene.meshes)
        for (const uvec3& t : mesh.triangles)
            for (int corner = 0; corner < 3; ++corner) points.push_back(mesh.positions[t[corner]]);
    return points;
}

inline bool hasRemark(const Scene& scene, const std::string& part) {
    for (const std::string& remark : scene.remarks)
        if (remark.find(part) != std::string::npos) return true;
    return false;
}

}  // namespace raig

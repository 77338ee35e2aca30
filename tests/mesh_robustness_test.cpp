/// Mesh files as the world has them, whole, cut off and damaged: each loads or is refused with one line.
#include "base/files.hpp"
#include "scene/geometry.hpp"
#include "scene/import.hpp"
#include "support/mesh_files.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <set>
#include <sstream>

namespace raig {
namespace {

namespace fs = std::filesystem;

const fs::path scenesFolder = fs::path(RAIG_SOURCE_DIR) / ".." / "shared" / "scenes";

/// The files of these formats that the scene set holds, by name.
std::vector<fs::path> meshFiles() {
    static const std::set<std::string> endings{".obj", ".ply", ".stl", ".off", ".3ds"};
    std::vector<fs::path> files;
    if (fs::exists(scenesFolder))
        for (const auto& entry : fs::recursive_directory_iterator(scenesFolder))
            if (endings.contains(entry.path().extension())) files.push_back(fs::relative(entry.path(), scenesFolder));
    std::ranges::sort(files);
    return files;
}

/// How many triangles the set's list gives each file.
std::map<std::string, size_t> listedTriangles() {
    std::map<std::string, size_t> listed;
    std::ifstream list(scenesFolder / "MANIFEST.csv");
    for (std::string line; std::getline(list, line);) {
        std::vector<std::string> fields;
        std::istringstream row(line);
        for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
        if (fields.size() > 6 && !fields[6].empty() && fields[6].find_first_not_of("0123456789") == std::string::npos)
            listed[fields[0]] = std::stoul(fields[6]);
    }
    return listed;
}

/// The number of triangles; nothing if the file is refused. Fails the test for any exception but an Error of bad input.
std::optional<size_t> trianglesOf(const fs::path& path) {
    try {
        const Scene scene = importScene(path);
        return flatten(scene).triangles.size();
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::badInput) << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return std::nullopt;
    }
}

#define SKIP_WITHOUT_SCENES() \
    if (!fs::exists(scenesFolder)) GTEST_SKIP() << "the scene set is not at " << scenesFolder

TEST(MeshFiles, GoodScenesHaveTheListedNumberOfTriangles) {
    SKIP_WITHOUT_SCENES();
    const auto listed = listedTriangles();
    size_t checked = 0;
    for (const fs::path& file : meshFiles()) {
        if (*file.begin() == "bad") continue;
        ASSERT_TRUE(listed.contains(file)) << file;
        EXPECT_EQ(trianglesOf(scenesFolder / file), listed.at(file)) << file;
        ++checked;
    }
    EXPECT_GE(checked, 9u);
}

// The list counts what other readers made of damaged files. Where that differs from ours, the reason stands here.
const std::map<std::string, std::string> differences{
    {"bad/assimp/OBJ/box_UTF16BE.obj", "UTF-16 is refused, not read as nothing"},
    {"bad/assimp/OBJ/box_longline.obj", "a polygon of 934 corners is fanned, not clipped"},
    {"bad/assimp/OBJ/concave_polygon.obj", "a concave polygon is fanned, not clipped"},
    {"bad/assimp/OBJ/space_in_material_name.obj", "a concave polygon is fanned, not clipped"},
    {"bad/assimp/OBJ/number_formats.obj", "3.1+e2 is no number"},
    {"bad/assimp/PLY/issue623.ply", "its vertices announce lists that they do not have"},
    {"bad/assimp/invalid/empty.ply", "no header"},
    {"bad/assimp/invalid/malformed.obj", "index 0"},
    {"bad/authored/obj_index_overflow.obj", "an index beyond the end"},
    {"bad/authored/obj_line_1MB.obj", "a polygon of 60,000 corners is fanned, not dropped"},
    {"bad/authored/obj_relative_beyond_start.obj", "an index before the start"},
    {"bad/authored/ply_index_out_of_range.ply", "an index beyond the end"},
    {"bad/authored/ply_negative_index.ply", "a negative index"},
    {"bad/authored/ply_vertex_count_4e9.ply", "cut off"},
    {"bad/authored/stl_count_ffffffff.stl", "cut off"},
    {"bad/stl-models/broken/empty.stl", "no header"},
    {"bad/stl-models/broken/fourVertices.ascii.stl", "a facet of four corners is fanned"},
    {"bad/stl-models/broken/incorrectFaceCounter.bin.stl", "the count contradicts the size"},
    {"bad/stl-models/broken/missingEndsolid.ascii.stl", "cut off"},
    {"bad/stl-models/broken/missingNormal.ascii.stl", "normals are not needed"},
    {"bad/stl-models/broken/quad.ascii.stl", "a facet of four corners is fanned"},
    {"bad/stl-models/broken/twoVertices.ascii.stl", "a facet of two corners is counted, the others are read"},
    {"bad/stl-models/misc/multiWordName.bin.stl", "the count contradicts the size"},
    {"bad/draco/test_wrong_attribute_mapping.obj", "faces name normals of which there are none"},
    {"bad/tinyobjloader/models/catmark_torus_creases0.obj", "faces name normals of which there are none"},
    {"bad/tinyobjloader/models/invalid-relative-texture-index.obj", "an index before the start"},
    {"bad/tinyobjloader/models/issue-140-zero-face-idx.obj", "index 0"},
    {"bad/tinyobjloader/models/issue-319-002.obj", "a concave polygon is fanned, not clipped"},
    {"bad/trimesh/jacked.obj", "corners of the form v/vt/ are read"},
    {"bad/trimesh/notenoughindices.obj", "a face of two corners is counted, the other is read"},
};

TEST(MeshFiles, BadScenesLoadAsListedOrAreRefused) {
    SKIP_WITHOUT_SCENES();
    const auto listed = listedTriangles();
    for (const fs::path& file : meshFiles()) {
        if (*file.begin() != "bad") continue;
        const auto start = std::chrono::steady_clock::now();
        const std::optional<size_t> triangles = trianglesOf(scenesFolder / file);
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)) << file;
        const std::string ending = file.extension();
        if (ending == ".off" || ending == ".3ds") {
            EXPECT_EQ(triangles, std::nullopt) << file;
        } else if (!differences.contains(file) && listed.contains(file)) {
            EXPECT_EQ(triangles, listed.at(file)) << file;
        }
    }
}

/// Small files of every kind of trouble, whole.
std::vector<fs::path> smallFiles() {
    std::vector<fs::path> files;
    for (const fs::path& file : meshFiles()) {
        const std::string ending = file.extension();
        if (ending != ".off" && ending != ".3ds" && fs::file_size(scenesFolder / file) <= 900) files.push_back(file);
    }
    return files;
}

std::string contentOf(const fs::path& path) {
    const std::vector<std::byte> bytes = readFile(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(MeshFiles, EveryTruncationLoadsOrIsRefused) {
    SKIP_WITHOUT_SCENES();
    const Folder folder;
    for (const fs::path& file : smallFiles()) {
        const std::string whole = contentOf(scenesFolder / file);
        for (size_t length = 0; length < whole.size(); ++length)
            trianglesOf(folder.write("cut" + file.extension().string(), std::string_view(whole).substr(0, length)));
        ASSERT_FALSE(HasFailure()) << file;
    }
}

TEST(MeshFiles, FlippedBytesLoadOrAreRefused) {
    SKIP_WITHOUT_SCENES();
    const Folder folder;
    std::mt19937 random(7);
    for (const fs::path& file : smallFiles()) {
        const std::string whole = contentOf(scenesFolder / file);
        if (whole.empty()) continue;
        for (int round = 0; round < 150; ++round) {
            std::string damaged = whole;
            for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
                // Digits and separators do more harm to a text than bytes that no word may hold.
                static constexpr std::string_view harmful = "0123456789-+./e \n\\#\xff";
                char& byte = damaged[random() % damaged.size()];
                byte =
                    random() % 2 == 0 ? harmful[random() % harmful.size()] : static_cast<char>(byte ^ (1u << random() % 8));
            }
            trianglesOf(folder.write("damaged" + file.extension().string(), damaged));
            ASSERT_FALSE(HasFailure()) << file << " round " << round;
        }
    }
}

TEST(MeshFiles, LibrariesOfAnyContentLeaveTheSceneUsable) {
    SKIP_WITHOUT_SCENES();
    const Folder folder;
    std::mt19937 random(11);
    const std::string whole = contentOf(scenesFolder / "bad/tinyobjloader/models/texture-options-issue-85.mtl") +
                              contentOf(scenesFolder / "bad/tinyobjloader/models/pbr-mat-ext.mtl") +
                              contentOf(scenesFolder / "bad/tinyobjloader/models/tr-and-d-issue-43.mtl");
    const fs::path scene =
        folder.write("s.obj", "mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl default\nf 1 2 3\nusemtl pbr\nf 1 2 3\n");
    for (int round = 0; round < 2000; ++round) {
        std::string damaged = whole.substr(0, random() % whole.size());
        for (int flips = 0; flips < 8 && !damaged.empty(); ++flips)
            damaged[random() % damaged.size()] = static_cast<char>(random());
        folder.write("s.mtl", damaged);
        ASSERT_EQ(trianglesOf(scene), 2u);
    }
}

}  // namespace
}  // namespace raig

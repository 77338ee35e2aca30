/// PLY and STL: what is read, and what is refused with which line.
#include "support/mesh_files.hpp"
#include "scene/import.hpp"
#include "scene/validate.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace raig {
namespace {

namespace fs = std::filesystem;

Scene loadPly(std::string_view content) {
    const Folder folder;
    const Scene scene = importPly(folder.write("scene.ply", content));
    EXPECT_EQ(findFault(scene), std::nullopt);
    return scene;
}

std::string refusalOfPly(std::string_view content) {
    return refusalOf(importPly, "scene.ply", content);
}

// ---- PLY ---------------------------------------------------------------------------------------------------------------

/// Appends a value of a binary body.
template <class T>
void put(std::string& body, T value, bool bigEndian) {
    std::string raw(sizeof value, '\0');
    std::memcpy(raw.data(), &value, sizeof value);
    if (bigEndian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    body += raw;
}

const std::string mixedHeader =
    "comment any order, any type\n"
    "element extra 2\nproperty list ushort double values\nproperty short one\n"
    "element vertex 4\nproperty uchar blue\nproperty double z\nproperty int16 x\nproperty float confidence\nproperty float "
    "y\n"
    "property uchar green\nproperty uint8 red\nproperty float s\nproperty float t\nproperty float nz\nproperty float "
    "ny\nproperty float nx\n"
    "element none 4000000000\n"
    "element face 3\nproperty uchar flags\nproperty list uint16 uint32 vertex_index\nproperty list char float weights\n"
    "end_header\n";

std::string mixedBinary(bool bigEndian) {
    std::string s = "ply\nformat binary_" + std::string(bigEndian ? "big" : "little") + "_endian 1.0\n" + mixedHeader;
    for (int i = 0; i < 2; ++i) {
        put<uint16_t>(s, 2, bigEndian);
        put(s, 1.5, bigEndian);
        put(s, 2.5, bigEndian);
        put<int16_t>(s, -3, bigEndian);
    }
    for (int i = 0; i < 4; ++i) {
        put<uint8_t>(s, 255, bigEndian);
        put<double>(s, 0.25 * i, bigEndian);
        put<int16_t>(s, static_cast<int16_t>(i * i - 300), bigEndian);
        put<float>(s, 9.0f, bigEndian);
        put<float>(s, static_cast<float>(i) + 0.5f, bigEndian);
        put<uint8_t>(s, 0, bigEndian);
        put<uint8_t>(s, 128, bigEndian);
        for (const float value : {0.25f, 0.25f, 2.0f, 0.0f, 0.0f}) put(s, value, bigEndian);
    }
    for (const std::vector<uint32_t>& face : {std::vector<uint32_t>{0, 1, 2, 3}, {3, 2, 1}, {0, 1}}) {
        put<uint8_t>(s, 7, bigEndian);
        put<uint16_t>(s, static_cast<uint16_t>(face.size()), bigEndian);
        for (const uint32_t corner : face) put(s, corner, bigEndian);
        put<int8_t>(s, 1, bigEndian);
        put<float>(s, 0.5f, bigEndian);
    }
    return s;
}

std::string mixedAscii() {
    std::string s = "ply\nformat ascii 1.0\n" + mixedHeader + "2 1.5 2.5 -3\n2 1.5 2.5 -3\n";
    for (int i = 0; i < 4; ++i) s += fmt::format("255 {} {} 9 {} 0 128 0.25 0.25 2 0 0\n", 0.25 * i, i * i - 300, i + 0.5);
    return s + "7 4 0 1 2 3 1 0.5\n7 3 3 2 1 1 0.5\n7 2 0 1 1 0.5\n";
}

TEST(Ply, AnyOrderTypeAndEncodingGivesTheSameMesh) {
    for (const std::string& content : {mixedAscii(), mixedBinary(false), mixedBinary(true)}) {
        const Scene scene = loadPly(content);
        const Mesh& mesh = scene.meshes.at(0);
        ASSERT_EQ(mesh.positions.size(), 4u);
        for (int i = 0; i < 4; ++i) {
            EXPECT_EQ(mesh.positions[i], vec3(i * i - 300, i + 0.5, 0.25 * i));
            EXPECT_EQ(mesh.normals[i], vec3(0, 0, 1));
            EXPECT_EQ(mesh.uvs[i], vec2(0.25f, 0.75f));
            EXPECT_EQ(mesh.colors[i].y, 0.0f);
            EXPECT_EQ(mesh.colors[i].z, 1.0f);
            EXPECT_NEAR(mesh.colors[i].x, 0.215861f, 1e-5f) << "sRGB 128";
        }
        EXPECT_EQ(mesh.triangles, (std::vector<uvec3>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}}));
        EXPECT_EQ(scene.otherPrimitives, 1u);
    }
}

TEST(Ply, EveryTruncationOfABinaryFileIsRefused) {
    for (const bool bigEndian : {false, true}) {
        const std::string whole = mixedBinary(bigEndian);
        for (size_t length = 0; length < whole.size(); ++length)
            ASSERT_NE(refusalOfPly(std::string_view(whole).substr(0, length)), "") << length;
    }
}

std::string plyTriangle(const std::string& vertexCount, const std::string& face, const std::string& body) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertexCount +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list " + face +
           " vertex_indices\nend_header\n" + body;
}

TEST(Ply, CountsAreCheckedBeforeAnythingIsAllocated) {
    for (const char* count : {"4000000000", "4294967295", "18446744073709551615", "9223372036854775807", "-1", "4"})
        EXPECT_NE(refusalOfPly(plyTriangle(count, "uchar int", "0 0 0 1 0 0 0 1 0\n3 0 1 2\n")), "") << count;
    EXPECT_NE(refusalOfPly(plyTriangle("3", "uint int", "0 0 0 1 0 0 0 1 0\n4294967295 0 1 2\n")), "");
    EXPECT_NE(refusalOfPly(plyTriangle("3", "int int", "0 0 0 1 0 0 0 1 0\n-1 0 1 2\n")), "");
}

TEST(Ply, NamesTheLineOrTheFaceOfAWrongIndex) {
    EXPECT_TRUE(refusalOfPly(plyTriangle("3", "uchar int", "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n")).starts_with("scene.ply:13: "));
    EXPECT_TRUE(
        refusalOfPly(plyTriangle("3", "uchar int", "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n")).starts_with("scene.ply:13: "));
    EXPECT_TRUE(refusalOfPly(plyTriangle("3", "uchar int", "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n")).starts_with("scene.ply:11: "));
    std::string binary = mixedBinary(false);
    binary[binary.size() - 5 - 4 - 4] = 9;  // the last face's first corner
    EXPECT_TRUE(refusalOfPly(binary).starts_with("scene.ply: face 2: "));
}

TEST(Ply, RefusesAMalformedHeaderWithItsLine) {
    EXPECT_TRUE(refusalOfPly("ply\nformat utf8 1.0\nend_header\n").starts_with("scene.ply:2: "));
    EXPECT_TRUE(refusalOfPly("ply\nformat ascii 1.0\nelement vertex three\nend_header\n").starts_with("scene.ply:3: "));
    EXPECT_TRUE(refusalOfPly("ply\nformat ascii 1.0\nproperty float x\nend_header\n").starts_with("scene.ply:3: "));
    EXPECT_TRUE(
        refusalOfPly("ply\nformat ascii 1.0\nelement vertex 0\nproperty quad x\nend_header\n").starts_with("scene.ply:4: "));
    EXPECT_TRUE(refusalOfPly("ply\nformat ascii 1.0\nelement f 0\nproperty list float int x\nend_header\n")
                    .starts_with("scene.ply:4: "));
    EXPECT_TRUE(refusalOfPly("ply\nformat ascii 1.0\nelement a 0\nelement a 0\nend_header\n").starts_with("scene.ply:4: "));
    for (const char* content : {"", "ply", "ply\n", "plx\nend_header\n", "ply\nend_header\n", "ply\nformat ascii 1.0\n"})
        EXPECT_NE(refusalOfPly(content), "") << content;
}

TEST(Ply, PointCloudsLoadAndAreCounted) {
    const Scene scene = loadPly(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0 1 "
        "nan 1");
    EXPECT_EQ(scene.otherPrimitives, 2u);
    EXPECT_TRUE(scene.meshes[0].triangles.empty());
}

TEST(Ply, ReadsFilesWithCarriageReturnsOnly) {
    std::string body;
    for (const float value : {10.0f, 0.0f, 0.0f}) put(body, value, false);
    body[0] = '\n';  // a data byte that a line reader would swallow
    const Scene scene = loadPly(
        "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty float x\rproperty float y\rproperty float "
        "z\rend_header\r" +
        body);
    float x = 0;
    std::memcpy(&x, body.data(), sizeof x);
    EXPECT_EQ(scene.meshes[0].positions.at(0).x, x);
}

// ---- STL ---------------------------------------------------------------------------------------------------------------

std::string binaryStl(const std::string& header, uint32_t count, const std::vector<vec3>& points) {
    std::string s = header;
    s.resize(80, ' ');
    put(s, count, false);
    for (size_t i = 0; i + 2 < points.size(); i += 3) {
        for (int k = 0; k < 3; ++k) put(s, NAN, false);
        for (int corner = 0; corner < 3; ++corner)
            for (int k = 0; k < 3; ++k) put(s, points[i + corner][k], false);
        put<uint16_t>(s, 0, false);
    }
    return s;
}

const std::vector<vec3> twoTriangles{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1.5f, 0, 1e-3f}, {0, 7, 1}};

std::string asciiStl(const std::vector<vec3>& points, size_t solids) {
    std::string s;
    for (size_t i = 0; i + 2 < points.size(); i += 3) {
        if (i == 0 || solids > 1) s += "Solid any name facet\n";
        s += " facet NORMAL nan nan nan\n  outer loop\n";
        for (int corner = 0; corner < 3; ++corner)
            s += fmt::format("vertex {} {} {}\n", points[i + corner].x, points[i + corner].y, points[i + corner].z);
        s += "  endloop\n endfacet\n";
        if (i + 3 >= points.size() || solids > 1) s += "endsolid any name facet\n";
    }
    return s;
}

TEST(Stl, AsciiAndBinaryGiveTheSameTriangles) {
    const Folder folder;
    for (const std::string& content : {asciiStl(twoTriangles, 1), asciiStl(twoTriangles, 2), binaryStl("", 2, twoTriangles),
                                       binaryStl("solid but binary", 2, twoTriangles)}) {
        const Scene scene = importStl(folder.write("s.stl", content));
        EXPECT_EQ(findFault(scene), std::nullopt);
        EXPECT_EQ(corners(scene), twoTriangles);
    }
}

TEST(Stl, EveryTruncationIsRefused) {
    const Folder folder;
    for (const std::string& whole :
         {asciiStl(twoTriangles, 1), binaryStl("", 2, twoTriangles), binaryStl("solid", 2, twoTriangles)}) {
        const size_t end = whole.starts_with("Solid") ? whole.find("endsolid") + 8 : whole.size();
        for (size_t length = 0; length < end; ++length) {
            if (whole.starts_with("Solid") && length == 0) continue;
            const fs::path path = folder.write("s.stl", std::string_view(whole).substr(0, length));
            ASSERT_NE(errorOf([&] { importStl(path); }), "") << length;
        }
    }
}

TEST(Stl, ACountThatTheSizeContradictsIsRefused) {
    const Folder folder;
    for (const uint32_t count : {0u, 1u, 3u, 0xffffffffu})
        EXPECT_NE(errorOf([&] { importStl(folder.write("s.stl", binaryStl("", count, twoTriangles))); }), "") << count;
}

TEST(Stl, NamesTheLineOfAMistake) {
    const Folder folder;
    std::string content = asciiStl(twoTriangles, 1);
    content.replace(content.find("vertex 1"), 8, "vertex x");
    EXPECT_NE(errorOf([&] { importStl(folder.write("s.stl", content)); }).find("s.stl:5: "), std::string::npos);
}

// ---- Endings ------------------------------------------------------------------------------------------------------------

TEST(Import, RefusesOtherFormatsByName) {
    const Folder folder;
    for (const char* name : {"a.off", "a.3ds", "a", "a.obj.bak", ".obj"}) {
        const std::string error = errorOf([&] { importScene(folder.write(name, "")); });
        EXPECT_NE(error.find(".gltf .glb .obj .ply .stl"), std::string::npos) << name << ": " << error;
    }
    EXPECT_NE(errorOf([&] { importScene("/no/such/file.obj"); }).find("cannot be opened"), std::string::npos);
}

TEST(Import, EndingsMayBeInAnyCase) {
    const Folder folder;
    EXPECT_EQ(importScene(folder.write("A.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).meshes.at(0).triangles.size(), 1u);
}

}  // namespace
}  // namespace raig

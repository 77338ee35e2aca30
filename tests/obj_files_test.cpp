/// OBJ with MTL: what is read, in which order, and what is refused with which line.
#include "scene/import.hpp"
#include "scene/obj.hpp"
#include "scene/surface.hpp"
#include "scene/validate.hpp"
#include "support/mesh_files.hpp"

namespace raig {
namespace {

namespace fs = std::filesystem;

Scene loadObj(std::string_view content) {
    const Folder folder;
    const Scene scene = importObj(folder.write("scene.obj", content));
    EXPECT_EQ(findFault(scene), std::nullopt);
    return scene;
}

std::string refusalOfObj(std::string_view content) {
    return refusalOf(importObj, "scene.obj", content);
}

// ---- OBJ ---------------------------------------------------------------------------------------------------------------

const std::string fiveVertices = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\n";

TEST(Obj, FansPolygonsFromTheirFirstCorner) {
    const Scene scene = loadObj(fiveVertices + "f 2 3 4 5 1\n");
    const vec3 a(1, 0, 0), b(2, 1, 0), c(1, 2, 0), d(0, 2, 0), e(0, 0, 0);
    EXPECT_EQ(corners(scene), (std::vector{a, b, c, a, c, d, a, d, e}));
}

TEST(Obj, KeepsFileOrderAcrossGroupsObjectsAndMaterials) {
    const Scene scene =
        loadObj(fiveVertices + "g one\nusemtl a\nf 1 2 3\no two\nusemtl b\nf 2 3 4\ng one\nusemtl a\nf 3 4 5\n");
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.meshes[0].materials, (std::vector<uint32_t>{0, 1, 0}));
    EXPECT_EQ(scene.materials.at(0).name, "a");
    EXPECT_EQ(scene.materials.at(1).name, "b");
    EXPECT_EQ(corners(scene).at(3), vec3(1, 0, 0));
}

TEST(Obj, CountsNegativeIndicesFromTheFace) {
    const Scene scene = loadObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -1 -2 1\n");
    EXPECT_EQ(corners(scene).at(2), vec3(0, 1, 0));
    EXPECT_EQ(corners(scene).at(3), vec3(5, 5, 5));
}

TEST(Obj, AllowsFacesBeforeTheirVertices) {
    EXPECT_EQ(loadObj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").meshes[0].triangles.size(), 1u);
}

TEST(Obj, NamesTheLineOfAWrongIndex) {
    EXPECT_TRUE(refusalOfObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n").starts_with("scene.obj:4: "));
    EXPECT_TRUE(refusalOfObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 1 2 3\n").starts_with("scene.obj:5: "));
    EXPECT_TRUE(refusalOfObj("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 0\r\n").starts_with("scene.obj:4: "));
    EXPECT_TRUE(refusalOfObj("v 0 0 0\nv 1 0 0\nv 0 1 0\n\\\n\nf 1/1 2/1 3/1\n").starts_with("scene.obj:6: "));
    for (const char* face : {"f 1 2 x", "f 1 2 3x", "f 1 2 1.5", "f 1 2 99999999999999999999", "f 1 2 2147483648",
                             "f 1//1 2 3", "f /1 2 3", "f 1/1/1/1 2 3", "f 1 2 -4", "f 1 2 --1"})
        EXPECT_TRUE(refusalOfObj("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + std::string(face)).starts_with("scene.obj:4: ")) << face;
}

TEST(Obj, NamesTheLineOfAWrongNumber) {
    for (const char* statement :
         {"v 1 2 abc", "v 1 2", "v", "v 1 2 3.1+e2", "v 1 2 +-3", "v 1,5 2 3", "vn 1 2", "vt", "vt x", "v 0x1p3 0 0"})
        EXPECT_TRUE(refusalOfObj("\n" + std::string(statement) + "\n").starts_with("scene.obj:2: ")) << statement;
}

TEST(Obj, ReadsEverySpellingOfANumber) {
    const Scene scene =
        loadObj("v +1 2. .5\nv -1e2 2.E+1 1e-2\nv nan -inf 1e39\nv 1.#INF -1.#IND 1e-50\nf 1 2 3\nf 2 3 4\n");
    const std::vector<vec3> at = corners(scene);
    EXPECT_EQ(at[0], vec3(1.0f, 2.0f, 0.5f));
    EXPECT_EQ(at[1], vec3(-100.0f, 20.0f, 0.01f));
    EXPECT_TRUE(std::isnan(at[2].x) && at[2].y == -INFINITY && at[2].z == INFINITY);
    EXPECT_TRUE(at[5].x == INFINITY && std::isnan(at[5].y) && at[5].z == 0.0f);
}

TEST(Obj, AcceptsByteOrderMarkCrLfCrCommentsAndContinuedLines) {
    const std::string plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::string crLf = "\xef\xbb\xbf" + plain, cr = plain;
    for (size_t at = 0; (at = crLf.find('\n', at)) != std::string::npos; at += 2) crLf.replace(at, 1, "\r\n");
    for (char& c : cr) c = c == '\n' ? '\r' : c;
    EXPECT_EQ(corners(loadObj(crLf)), corners(loadObj(plain)));
    EXPECT_EQ(corners(loadObj(cr)), corners(loadObj(plain)));
    EXPECT_EQ(corners(loadObj("# C:\\\nv 0 0\\\n0 # a\n\tv 1 0 0\nv 0 1 0\nf 1 \\\r\n 2 3 # 4 5")), corners(loadObj(plain)));
}

TEST(Obj, RefusesWhatIsNoText) {
    EXPECT_NE(refusalOfObj("\xff\xfev\0 \0"), "");
    EXPECT_TRUE(refusalOfObj(std::string_view("v 0 0 0\n\0\n", 10)).starts_with("scene.obj:2: "));
}

TEST(Obj, CountsWhatIsNoTriangle) {
    const Scene scene = loadObj(fiveVertices + "p 1 2 3\nl 1 2 3\nf 1 2\nf\nf 1 2 3\n");
    EXPECT_EQ(scene.otherPrimitives, 3u + 1u + 2u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
}

TEST(Obj, SaysWhatItDoesNotKnow) {
    EXPECT_TRUE(hasRemark(loadObj("v 0 0 0\ncurv 0 1 1 2\nv\t1 0 0\n"), "scene.obj:2: 'curv'"));
    EXPECT_TRUE(loadObj("# nothing\n\ng a\ns off\no b\n").remarks.empty());
}

TEST(Obj, MakesOneVertexOfEachDifferentCorner) {
    const std::string attributes = "vt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 0 nan 0\n";
    const Scene scene = loadObj(fiveVertices + attributes + "f 1/1/1 2/1/1 3/2/1\nf 1/1/1 3/2/1 4/2/2\nf 1/2/1 3/2 2//1\n");
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.positions.size(), 7u);
    EXPECT_EQ(mesh.triangles[0].x, mesh.triangles[1].x);
    EXPECT_NE(mesh.triangles[0].x, mesh.triangles[2].x);
    EXPECT_EQ(mesh.uvs[mesh.triangles[0].z], vec2(1.0f, 0.75f)) << "v counts downwards in a Scene";
    EXPECT_EQ(mesh.normals[mesh.triangles[0].x], vec3(0, 0, 1)) << "made unit";
    EXPECT_EQ(mesh.normals[mesh.triangles[1].z], vec3(0)) << "no number, so none";
    EXPECT_EQ(mesh.normals[mesh.triangles[2].y], vec3(0)) << "none given";
}

TEST(Obj, DecodesVertexColors) {
    const Mesh mesh = loadObj("v 0 0 0 1 0 0.5\nv 1 0 0 1\nv 0 1 0 nan 0 0\nf 1 2 3\n").meshes[0];
    EXPECT_NEAR(mesh.colors[0].z, 0.21404f, 1e-5f);
    EXPECT_EQ(mesh.colors[0].x, 1.0f);
    EXPECT_EQ(mesh.colors[1], vec3(1.0f));
    EXPECT_EQ(mesh.colors[2], vec3(1.0f));
}

// One position with very many partners: must stay linear.
TEST(Obj, StaysFastWhereOnePositionHasManyNormals) {
    std::string content = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 1; i <= 100'000; ++i) content += "vn 0 0 1\nf 1//" + std::to_string(i) + " 2 3\n";
    EXPECT_EQ(loadObj(content).meshes[0].triangles.size(), 100'000u);
}

// ---- MTL ---------------------------------------------------------------------------------------------------------------

Material materialOf(const std::string& statements) {
    std::vector<std::string> remarks;
    const auto materials = readMtl("newmtl m\n" + statements, "m.mtl", remarks);
    EXPECT_TRUE(remarks.empty()) << remarks.front();
    return toMaterial(materials.at(0));
}

void expectNear(const vec3& got, const vec3& want, float tolerance) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], tolerance) << "channel " << i;
}

TEST(Mtl, HighlightsAloneAreNoMirrors) {
    const Surface s = surfaceOf(materialOf("Kd .3 .5 .8\nKs 1.2 1.2 1.2\nNs 684\nillum 2\nd 1\nNi 1\n"));
    EXPECT_EQ(s.gloss, 0.0f);
    EXPECT_EQ(s.mirror, vec3(0.0f));
    EXPECT_EQ(s.diffuse, vec3(0.3f, 0.5f, 0.8f));
    EXPECT_EQ(s.transmission, vec3(0.0f));
    expectNear(s.f0, vec3(0.08f), 1e-6f);
    const Material broad = materialOf("Ks .5 .5 .5\nNs 6\nillum 2\n");
    EXPECT_NEAR(broad.roughness, std::sqrt(0.5), 1e-6) << "a^2 = 2 / (Ns + 2), and roughness^2 = a";
    expectNear(surfaceOf(broad).f0, vec3(0.04f * (1.0f - std::pow(2.0f * broad.roughness - 1.0f, 2.0f))), 1e-6f);
    EXPECT_EQ(surfaceOf(materialOf("Kd 1 1 1\nNs 50\n")).f90, 0.0f) << "without Ks nothing shines";
}

TEST(Mtl, RayTracedReflectionIsAMirrorBesideTheDiffusePart) {
    expectNear(surfaceOf(materialOf("Kd 0 0 0\nKs .9 .8 .7\nillum 3\n")).mirror, {0.9f, 0.8f, 0.7f}, 1e-6f);
    const Surface both = surfaceOf(materialOf("Kd .4 .4 .4\nKs .4 .4 .4\nillum 5\n"));
    expectNear(both.diffuse, vec3(0.4f), 1e-6f);
    expectNear(both.mirror, vec3(0.4f), 0.03f);
    const Surface blurred = surfaceOf(materialOf("Kd 0 0 0\nKs .9 .9 .9\nNs 2\nillum 3\n"));
    EXPECT_EQ(blurred.gloss, 0.0f);
    expectNear(blurred.diffuse, vec3(0.0f), 1e-6f);
    expectNear(blurred.f0, vec3(0.9f), 1e-6f);
}

TEST(Mtl, WhatIsNotOpaqueIsGlass) {
    const Material glass = materialOf("Kd 0 .5 1\nNi 1.33\nd .25\nillum 2\n");
    EXPECT_EQ(glass.transmission, 1.0f);
    EXPECT_EQ(glass.ior, 1.33f);
    EXPECT_FALSE(glass.thin);
    expectNear(glass.baseColor, {0.75f, 0.875f, 1.0f}, 1e-6f);
    EXPECT_EQ(materialOf("Tr .75\n").ior, 1.5f);
    EXPECT_EQ(materialOf("Tr .75\nd 1\n").transmission, 0.0f) << "d is the standard's";
    EXPECT_EQ(materialOf("d -halo .5\nTf .1 .2 .3\n").baseColor, vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(materialOf("illum 7\nTf 1 1 1\nNi 1.5\nd 1\n").transmission, 1.0f);
    EXPECT_EQ(materialOf("illum 4\nTf 1 1 1\nNi 1\nd 1\n").transmission, 0.0f) << "what a modeller writes for opaque ones";
}

TEST(Mtl, EmissionAndDefaults) {
    EXPECT_EQ(materialOf("Kd 0 0 0\nKe 17 12 4\n").emission, vec3(17, 12, 4));
    EXPECT_EQ(materialOf("Kd .5\n").baseColor, vec3(0.5f));
    EXPECT_EQ(materialOf("").baseColor, vec3(0.8f));
    EXPECT_EQ(materialOf("map_Kd a.png\n").baseColor, vec3(1.0f));
    EXPECT_EQ(materialOf("Kd 2 -1 0\n").baseColor, vec3(1, 0, 0));
}

TEST(Mtl, MalformedStatementsAreRemarkedWithTheirLine) {
    std::vector<std::string> remarks;
    const auto materials =
        readMtl("newmtl m\nKd nan 0 0\nKd .1 .2\nNs x\nd\nKs 1e99 0 0\nKe spectral a.rfl\n", "m.mtl", remarks);
    ASSERT_EQ(remarks.size(), 6u);
    for (size_t i = 0; i < 6; ++i) EXPECT_TRUE(remarks[i].starts_with("m.mtl:" + std::to_string(i + 2) + ":")) << remarks[i];
    EXPECT_FALSE(materials.at(0).kd || materials.at(0).ks || materials.at(0).ke || materials.at(0).ns ||
                 materials.at(0).opacity);
}

TEST(Mtl, FindsTheFileNameBehindTheOptions) {
    for (const char* options :
         {"", "-clamp on", "-o 0.1", "-s 1 2 3 -t 0.1 0.2", "-blendu on -mm 0 1", "-type sphere", "-texres 512"}) {
        std::vector<std::string> remarks;
        const auto materials =
            readMtl("newmtl m\nmap_Kd " + std::string(options) + " dir\\my image.png \n", "m.mtl", remarks);
        EXPECT_EQ(materials.at(0).kdMap.file, "dir/my image.png") << options;
        EXPECT_EQ(materials.at(0).kdMap.clamps, std::string_view(options) == "-clamp on");
    }
}

/// A white 1 x 1 TGA.
const std::string tinyImage("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0\xff\xff\xff", 21);
const std::string oneFace = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

TEST(Mtl, ReadsLibrariesAndImagesBesideTheSceneOnce) {
    const Folder folder;
    folder.write(
        "sub dir/my lib.mtl",
        "newmtl a b\nKd .5 .5 .5\nmap_Kd ..\\t\\i.tga\nnewmtl c\nmap_Kd ../t/i.tga\nnewmtl unused\nmap_Kd no.tga\n");
    folder.write("t/i.tga", tinyImage);
    const Scene scene = importObj(folder.write(
        "s.obj", "mtllib sub dir\\my lib.mtl\nusemtl a b \n" + oneFace + "usemtl c\nf 1 2 3\nusemtl a b\nf 1 2 3\n"));
    EXPECT_EQ(findFault(scene), std::nullopt);
    EXPECT_TRUE(scene.remarks.empty()) << scene.remarks.front();
    ASSERT_EQ(scene.images.size(), 1u);
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[0].baseColor, vec3(0.5f));
    ASSERT_TRUE(scene.materials[0].baseColorTexture && scene.materials[1].baseColorTexture);
    EXPECT_EQ(scene.meshes[0].materials, (std::vector<uint32_t>{0, 1, 0}));
}

TEST(Mtl, SeveralLibrariesInOneStatement) {
    const Folder folder;
    folder.write("a.mtl", "newmtl a\nKd 1 0 0\n");
    folder.write("b.mtl", "newmtl b\nKd 0 1 0\n");
    const Scene scene =
        importObj(folder.write("s.obj", "usemtl b\n" + oneFace + "usemtl a\nf 1 2 3\nmtllib a.mtl missing.mtl b.mtl\n"));
    EXPECT_EQ(scene.materials.at(0).baseColor, vec3(0, 1, 0));
    EXPECT_EQ(scene.materials.at(1).baseColor, vec3(1, 0, 0));
    EXPECT_EQ(scene.remarks.size(), 1u);
    EXPECT_TRUE(hasRemark(scene, "missing.mtl"));
}

// A scene must not make the program read files elsewhere.
TEST(Mtl, NothingOutsideTheScenesFolderIsRead) {
    const Folder folder;
    folder.write("secret.mtl", "newmtl a\nKd 1 0 0\n");
    folder.write("secret.tga", tinyImage);
    folder.write("in/l.mtl", "newmtl b\nmap_Kd ../secret.tga\n");
    const std::string absolute = (folder.write("x", "").parent_path() / "secret.mtl").string();
    const Scene scene =
        importObj(folder.write("in/s.obj", "mtllib ../secret.mtl\nmtllib x/../../secret.mtl\nmtllib " + absolute +
                                               "\nmtllib l.mtl\nusemtl a\n" + oneFace + "usemtl b\nf 1 2 3\n"));
    EXPECT_EQ(scene.materials.at(0).baseColor, vec3(0.8f));
    EXPECT_TRUE(scene.images.empty());
    EXPECT_EQ(scene.remarks.size(), 5u) << "three libraries, one material, one image";
}

TEST(Mtl, AMissingOrDamagedImageIsARemark) {
    const Folder folder;
    folder.write("l.mtl", "newmtl a\nmap_Kd none.png\nnewmtl b\nmap_Kd bad.png\n");
    folder.write("bad.png", "this is no picture");
    const Scene scene = importObj(folder.write("s.obj", "mtllib l.mtl\nusemtl a\n" + oneFace + "usemtl b\nf 1 2 3\n"));
    EXPECT_TRUE(hasRemark(scene, "none.png"));
    EXPECT_TRUE(hasRemark(scene, "bad.png"));
    EXPECT_FALSE(scene.materials.at(0).baseColorTexture || scene.materials.at(1).baseColorTexture);
}

}  // namespace
}  // namespace raig

// Structures of two levels in files: what comes back is what was saved, and whatever else a file holds is refused.
#include "base/files.hpp"
#include "base/random.hpp"
#include "rays/lights.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"
#include "support/effort.hpp"
#include "support/groves.hpp"
#include "support/soups.hpp"
#include "support/structure_files.hpp"
#include "support/tracing.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <functional>

namespace raig {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;
using test::Grove;

/// Two small meshes in a few places, and one that stands once, with a sphere.
Scene clearing() {
    Scene scene;
    scene.materials.resize(2);
    scene.materials[1].transmission = 1.0f;
    Random random(7);
    for (const int triangles : {5, 4, 2}) {
        Mesh mesh;
        for (int i = 0; i < 3 * triangles; ++i) mesh.positions.push_back(random.inCube(-1, 1));
        for (uint32_t i = 0; i < 3u * triangles; i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
        mesh.materials.assign(triangles, 0);
        scene.meshes.push_back(std::move(mesh));
    }
    scene.meshes[2].spheres.push_back({vec3(0.5f, 0, 0), 0.75f});
    scene.meshes[2].materials.push_back(0);
    for (uint32_t i = 0; i < 5; ++i) {
        dmat4 place(1.0);
        place[1].x = 0.5 * i;
        place[2].z = i == 3 ? -1.5 : 1.0;
        place[3] = dvec4(random.inCube(-2, 2), 1);
        scene.instances.push_back({i % 2, place});
    }
    scene.instances.push_back({2, dmat4(1.0)});
    return scene;
}

/// A scene as it is kept, with rays and what they hit where it is written out.
struct Case {
    Case(const Scene& scene, size_t count)
        : geometry(gatherInstances(scene)), placed(placedScene(geometry, {})), written(primitivesOf(flatten(scene))) {
        if (!written.empty()) rays = test::rays(written, /* seed= */ 3, count);
        truth = test::traceOnCpu(structureType("brute").build(written, {}), rays);
    }
    Geometry geometry;
    PlacedScene placed;
    std::vector<Primitive> written;
    std::vector<Ray> rays;
    std::vector<Hit> truth;
};

class TwoLevelFiles : public test::OfStructureFiles {
protected:
    /// The bytes of a file of the clearing's bvh.
    Bytes saved() const {
        const Geometry geometry = gatherInstances(scene_);
        const PlacedScene placed = placedScene(geometry, {});
        saveStructure(file_, buildTwoLevels(placed, structureType("bvh"), {.walk = "trail"}), {.walk = "trail"}, placed);
        return readFile(file_);
    }
    std::string refusalOver(const Scene& scene, const KeepRule& rule = {}) const {
        const Geometry geometry = gatherInstances(scene);
        return refusal(placedScene(geometry, rule));
    }
    void expectRefusedOrGood(const StructureType& type);

    const Scene scene_ = clearing();
};

TEST_F(TwoLevelFiles, GiveBackWhatWasSaved) {
    size_t kept = 0;
    for (const Grove& grove : test::groves()) {
        const Case c(grove.scene, test::affordable(300));
        for (const test::Variant& variant : test::walkVariants()) {
            const Structure built = buildTwoLevels(c.placed, structureType(variant.structure), variant.params);
            saveStructure(file_, built, variant.params, c.placed);
            StructureFile file(file_);
            EXPECT_EQ(file.leastTriangles(), 1u);
            EXPECT_EQ(file.structureName(), variant.structure);
            EXPECT_EQ(file.options(), describeOptions(variant.params));
            const Structure loaded = file.read(c.placed);
            EXPECT_EQ(std::tie(loaded.name, loaded.walk, loaded.instances),
                      std::tie(built.name, built.walk, built.instances));
            EXPECT_EQ(std::memcmp(&loaded.header, &built.header, sizeof built.header), 0) << grove.name << ' ' << variant;
            EXPECT_EQ(loaded.nodes, built.nodes) << grove.name << ' ' << variant;
            EXPECT_EQ(loaded.triangles, built.triangles) << grove.name << ' ' << variant;
            ASSERT_EQ(loaded.bottoms.size(), built.bottoms.size());
            for (size_t i = 0; i < built.bottoms.size(); ++i) {
                const Bottom &a = loaded.bottoms[i], &b = built.bottoms[i];
                EXPECT_EQ(std::tie(a.mesh, a.firstReference, a.references),
                          std::tie(b.mesh, b.firstReference, b.references));
            }
            const StructureStatistics &a = loaded.statistics, &b = built.statistics;
            EXPECT_EQ(std::tie(a.nodes, a.leaves, a.depth, a.references, a.bytes, a.sahCost, a.seconds),
                      std::tie(b.nodes, b.leaves, b.depth, b.references, b.bytes, b.sahCost, b.seconds));
            EXPECT_TRUE(test::sameBits(test::traceOnCpu(loaded, c.rays), c.truth)) << grove.name << ' ' << variant;
            kept += loaded.instances;
        }
    }
    EXPECT_GT(kept, 100 * test::walkVariants().size());
}

// What was changed with intent has right checksums. Then it is refused, or it is as good as what was built.
void TwoLevelFiles::expectRefusedOrGood(const StructureType& type) {
    const Case c(scene_, test::affordable(100));
    const Structure built = buildTwoLevels(c.placed, type, {});
    ASSERT_EQ(built.bottoms.size(), 3u);
    size_t refused = 0, accepted = 0;
    const auto tryOut = [&](const std::function<void(Structure&)>& forge, const std::string& what) {
        Structure forged = built;
        forge(forged);
        saveStructure(file_, forged, {}, c.placed);
        if (!refusal(c.placed).empty()) {
            ++refused;
            return;
        }
        ++accepted;
        const Structure read = StructureFile(file_).read(c.placed);
        ASSERT_TRUE(test::sameBits(test::traceOnCpu(read, c.rays), c.truth)) << type.name << ' ' << what;
    };
    const auto piecesOf = [](Structure& s) {
        return std::array{std::as_writable_bytes(std::span(s.nodes)), std::as_writable_bytes(std::span(s.triangles)),
                          std::as_writable_bytes(std::span(&s.header, 1)), std::as_writable_bytes(std::span(s.bottoms)),
                          std::as_writable_bytes(std::span(&s.instances, 1))};
    };
    Random random(17);
    const auto below = [&](size_t count) { return static_cast<size_t>(random.unit() * static_cast<double>(count)); };
    const size_t rounds = test::isLong() ? 50'000 : test::affordable(300);
    for (size_t round = 0; round < rounds; ++round) {
        const size_t piece = below(5), bits = 1 + below(3);
        tryOut(
            [&](Structure& s) {
                const std::span<std::byte> bytes = piecesOf(s)[piece];
                for (size_t i = 0; i < bits && !bytes.empty(); ++i) bytes[below(bytes.size())] ^= std::byte(1u << below(8));
            },
            fmt::format("piece {} round {}", piece, round));
    }
    for (auto array : {&Structure::nodes, &Structure::triangles}) {
        tryOut([&](Structure& s) { (s.*array).resize((s.*array).size() + 3); }, "too long");
        for (size_t size = 0; size < (built.*array).size(); size += 1 + size / 8)
            tryOut([&](Structure& s) { (s.*array).resize(size); }, "too short");
    }
    for (size_t count = 0; count < 5; ++count) tryOut([&](Structure& s) { s.bottoms.resize(count); }, "bottoms");
    EXPECT_GT(refused, accepted) << type.name;
}

TEST_F(TwoLevelFiles, AreRefusedOrGoodHoweverTheyWereForged) {
    for (const StructureType& type : structureTypes()) expectRefusedOrGood(type);
}

// Sizes that the header lies about are told before memory is taken; so is what does not go with one level.
TEST_F(TwoLevelFiles, AreRefusedWithAForgedStart) {
    const Bytes bytes = saved();
    const auto forged = [&](const std::function<void(StructureFileHeader&)>& forge) {
        Bytes copy = bytes;
        StructureFileHeader header;
        std::memcpy(&header, copy.data(), sizeof header);
        forge(header);
        constexpr size_t start = offsetof(StructureFileHeader, arraysChecksum);
        header.headerChecksum = XXH3_64bits(reinterpret_cast<const char*>(&header) + start, sizeof header - start);
        std::memcpy(copy.data(), &header, sizeof header);
        write(copy);
        return refusalOver(scene_);
    };
    EXPECT_EQ(forged([](StructureFileHeader&) {}), "");
    for (const uint64_t many :
         {uint64_t{0}, uint64_t{2}, uint64_t{4}, ~uint64_t{0}, ~uint64_t{0} / 24 + 1, uint64_t{1} << 60}) {
        EXPECT_NE(forged([&](StructureFileHeader& h) { h.bottoms = many; }).find("bytes, not those of"), std::string::npos);
        EXPECT_NE(forged([&](StructureFileHeader& h) { h.nodeTexels = many; }).find("bytes, not those of"),
                  std::string::npos);
    }
    // 48 bytes are two bottoms, or three texels.
    EXPECT_NE(forged([](StructureFileHeader& h) { h.bottoms += 2, h.nodeTexels -= 3; }), "");
    EXPECT_NE(forged([](StructureFileHeader& h) { h.bottoms -= 2, h.nodeTexels += 3; }), "");
    EXPECT_NE(forged([](StructureFileHeader& h) { h.nodeTexels -= 3, h.triangleTexels += 3; }), "");
    EXPECT_NE(forged([](StructureFileHeader& h) { h.instances += 1; }).find("instances"), std::string::npos);
    EXPECT_NE(forged([](StructureFileHeader& h) { h.leastTriangles = 0; }).find("written out"), std::string::npos);
    EXPECT_NE(forged([](StructureFileHeader& h) { h.leastTriangles = 2; }).find("another scene"), std::string::npos);
    EXPECT_NE(forged([](StructureFileHeader& h) { h.structure = {'k', 'd', 't', 'r', 'e', 'e'}; }).find("broken"),
              std::string::npos);
}

TEST_F(TwoLevelFiles, AreRefusedCutAtEveryLengthOrLonger) {
    const size_t size = saved().size();
    const Geometry geometry = gatherInstances(scene_);
    const PlacedScene placed = placedScene(geometry, {});
    fs::resize_file(file_, size + 1);
    EXPECT_NE(refusal(placed), "");
    fs::resize_file(file_, size);
    EXPECT_EQ(refusal(placed), "");
    for (size_t length = size; length-- > 0;) {
        fs::resize_file(file_, length);
        ASSERT_NE(refusal(placed), "") << length;
    }
}

TEST_F(TwoLevelFiles, AreRefusedWithAnyByteChanged) {
    const Bytes bytes = saved();
    const Geometry geometry = gatherInstances(scene_);
    const PlacedScene placed = placedScene(geometry, {});
    std::fstream file(file_, std::ios::binary | std::ios::in | std::ios::out);
    const auto put = [&](size_t at, std::byte value) {
        file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(value)).flush();
    };
    for (size_t i = 0; i < bytes.size(); ++i) {
        put(i, bytes[i] ^ std::byte(1u << i % 8));
        ASSERT_NE(refusal(placed), "") << i;
        put(i, bytes[i]);
    }
    EXPECT_EQ(refusal(placed), "");
}

TEST_F(TwoLevelFiles, AreRefusedOverAnotherScene) {
    saved();
    const auto changed = [&](const std::function<void(Scene&)>& change) {
        Scene scene = scene_;
        change(scene);
        return refusalOver(scene);
    };
    const auto expectAnother = [](const std::string& text) {
        EXPECT_NE(text.find("another scene"), std::string::npos) << text;
    };
    EXPECT_EQ(changed([](Scene&) {}), "");
    expectAnother(changed([](Scene& s) { s.instances[1].toWorld[3].x += 1e-3; }));
    expectAnother(changed([](Scene& s) { std::swap(s.instances[0], s.instances[2]); }));
    expectAnother(changed([](Scene& s) { s.instances.pop_back(); }));
    expectAnother(changed([](Scene& s) { s.instances[3].mesh = 0; }));
    expectAnother(changed([](Scene& s) { s.meshes[0].positions[4].y += 0x1p-20f; }));
    expectAnother(changed([](Scene& s) { std::swap(s.meshes[1].triangles[0], s.meshes[1].triangles[1]); }));
    expectAnother(changed([](Scene& s) { s.meshes[2].spheres[0].radius *= 2; }));
    expectAnother(refusalOver(scene_, {.leastTriangles = 5}));
    Geometry geometry = gatherInstances(scene_);
    geometry.placed[2].mirrored = !geometry.placed[2].mirrored;
    expectAnother(refusal(placedScene(geometry, {})));
    // The same file read as of a scene written out, and the other way around.
    const std::vector<Primitive> written = primitivesOf(flatten(scene_));
    EXPECT_THROW(StructureFile(file_).read(written), Error);
    saveStructure(file_, structureType("bvh").build(written, {}), {}, written);
    expectAnother(refusalOver(scene_));
}

// What does not change where rays hit is the scene's own matter.
TEST_F(TwoLevelFiles, AreGoodWhateverTheMaterials) {
    saved();
    Scene painted = scene_;
    for (Mesh& mesh : painted.meshes) mesh.materials.assign(mesh.materials.size(), 1);
    painted.meshes[0].normals.assign(painted.meshes[0].positions.size(), vec3(0, 1, 0));
    EXPECT_EQ(refusalOver(painted), "");

    const Geometry geometry = gatherInstances(painted);
    const PlacedScene placed = placedScene(geometry, {});
    const Structure built = buildTwoLevels(placed, structureType("bvh"), {});
    Structure marked = built;
    markSeeThrough(painted, geometry, marked);
    EXPECT_NE(marked.triangles, built.triangles);
    saveStructure(file_, marked, {}, placed);
    EXPECT_EQ(StructureFile(file_).read(placed).triangles, built.triangles);
}

}  // namespace
}  // namespace raig

// Structures in files: what comes back is what was saved, and whatever else a file holds is refused with one line.
#include "base/files.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"
#include "support/structure_files.hpp"
#include "support/tracing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace raig {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

/// A structure built in one of its ways.
struct Variant {
    std::string name;
    BuildParams params;
    Structure build(std::span<const Triangle> triangles) const { return structureType(name).build(triangles, params); }
};

std::ostream& operator<<(std::ostream& out, const Variant& v) {
    return out << v.name << ' ' << describeOptions(v.params);
}

std::vector<Variant> variants() {
    std::vector<Variant> result;
    for (const StructureType& type : structureTypes()) result.push_back({std::string(type.name), {}});
    for (const char* bound : {"sphere", "obb", "kdop"}) result.push_back({"bvh", {.bound = bound}});
    result.push_back({"bvh", {.precision = 32}});
    result.push_back({"bvh", {.walk = "skip", .arity = 8}});
    result.push_back({"bvh", {.build = "sbvh"}});
    for (const uint32_t arity : {2, 4, 8})
        for (const uint32_t precision : {32, 16, 8})
            result.push_back({"bvh", {.walk = "trail", .arity = arity, .precision = precision}});
    result.push_back({"bvh", {.build = "sbvh", .walk = "trail", .precision = 8}});
    return result;
}

class StructureFiles : public test::OfStructureFiles {
protected:
    /// The bytes of a file of `structure`, a bvh unless told.
    Bytes saved(const std::vector<Triangle>& triangles, std::string_view type = "bvh", const BuildParams& params = {}) {
        saveStructure(file_, structureType(type).build(triangles, params), params, triangles);
        return readFile(file_);
    }

    const std::vector<Triangle> small_ = test::sphere(3, 1.0, dvec3(0.5, 2, 1), 0.1);
    const std::vector<Primitive> spheres_ = {
        small_[3], Primitive::sphere(vec3(0.5f, 2, 1), 0.5f),        Primitive::sphere(vec3(0.75f, 2.25f, 1), 0.125f),
        small_[7], Primitive::sphere(vec3(-0.1f, 1.3f, 0.7f), 0.7f), Primitive::sphere(vec3(1), 1e-3f)};
};

class EveryStructureFile : public StructureFiles, public testing::WithParamInterface<Variant> {
protected:
    void expectRefusedOrGood(const std::vector<Primitive>& primitives);
};

TEST_P(EveryStructureFile, GivesBackWhatWasSaved) {
    for (const test::Soup& soup : test::soups()) {
        const Structure built = GetParam().build(soup.triangles);
        saveStructure(file_, built, {}, soup.triangles);
        StructureFile file(file_);
        EXPECT_EQ(file.structureName(), GetParam().name);
        EXPECT_EQ(file.options(), "");
        const Structure loaded = file.read(soup.triangles);
        EXPECT_EQ(loaded.name, built.name);
        EXPECT_EQ(loaded.walk, built.walk);
        EXPECT_EQ(std::memcmp(&loaded.header, &built.header, sizeof built.header), 0) << soup.name;
        EXPECT_EQ(loaded.nodes, built.nodes) << soup.name;
        EXPECT_EQ(loaded.triangles, built.triangles) << soup.name;
        const StructureStatistics &a = loaded.statistics, &b = built.statistics;
        EXPECT_EQ(std::tie(a.nodes, a.leaves, a.depth, a.references, a.bytes, a.sahCost, a.seconds),
                  std::tie(b.nodes, b.leaves, b.depth, b.references, b.bytes, b.sahCost, b.seconds));
        const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 3, /* count= */ 500);
        EXPECT_TRUE(test::sameBits(test::traceOnCpu(loaded, rays), test::traceOnCpu(built, rays))) << soup.name;
    }
}

// What was changed with intent has right checksums. Then it is refused, or it is as good as what was built: whatever value
// of whatever byte, no walk over it leaves the arrays, hangs or misses.
TEST_P(EveryStructureFile, IsRefusedOrGoodHoweverItWasForged) {
    expectRefusedOrGood(small_);
}
TEST_P(EveryStructureFile, WithSpheresIsRefusedOrGoodHoweverItWasForged) {
    expectRefusedOrGood(spheres_);
}

void EveryStructureFile::expectRefusedOrGood(const std::vector<Primitive>& primitives) {
    const Structure built = GetParam().build(primitives);
    const std::vector<Ray> rays = test::rays(primitives, /* seed= */ 4, test::affordable(300));
    const std::vector<Hit> want = test::traceOnCpu(built, rays);
    size_t refused = 0, accepted = 0;
    const auto tryOut = [&](const Structure& forged, const std::string& what) {
        saveStructure(file_, forged, {}, primitives);
        if (!refusal(primitives).empty()) {
            ++refused;
            return;
        }
        ++accepted;
        EXPECT_TRUE(test::sameBits(test::traceOnCpu(StructureFile(file_).read(primitives), rays), want)) << what;
    };
    const auto forgeBytes = [&](auto bytesOf, const char* what) {
        Structure forged = built;
        const size_t count = bytesOf(forged).size();
        for (size_t i = 0; i < count; ++i)
            for (const std::byte change : {std::byte{0x01}, std::byte{0x80}, std::byte{0xff}}) {
                if (count > 1000 && (i + static_cast<size_t>(change)) % 3 != 0) continue;  // one of them for each
                forged = built;
                bytesOf(forged)[i] ^= change;
                tryOut(forged, fmt::format("{} byte {} ^ {:#x}", what, i, static_cast<int>(change)));
            }
    };
    forgeBytes([](Structure& s) { return std::as_writable_bytes(std::span(s.nodes)); }, "nodes");
    forgeBytes([](Structure& s) { return std::as_writable_bytes(std::span(s.triangles)); }, "triangles");
    forgeBytes([](Structure& s) { return std::as_writable_bytes(std::span(&s.header, 1)); }, "header");
    EXPECT_GT(refused, accepted / 4) << "what is changed at random is seldom as good: some bounds may be looser";
    for (auto array : {&Structure::nodes, &Structure::triangles}) {
        Structure forged = built;
        (forged.*array).resize((forged.*array).size() + 3);
        tryOut(forged, "too long");
        if ((built.*array).empty()) continue;
        (forged.*array).resize((built.*array).size() - 1);
        tryOut(forged, "too short");
    }
}

INSTANTIATE_TEST_SUITE_P(, EveryStructureFile, testing::ValuesIn(variants()), [](const auto& info) {
    std::string name = info.param.name + describeOptions(info.param.params);
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
    return name;
});

TEST_F(StructureFiles, AreRefusedCutAtEveryLengthOrLonger) {
    const size_t size = saved(small_).size();
    fs::resize_file(file_, size + 1);
    EXPECT_NE(refusal(small_), "");
    fs::resize_file(file_, size);
    EXPECT_EQ(refusal(small_), "");
    for (size_t length = size; length-- > 0;) {
        fs::resize_file(file_, length);
        ASSERT_NE(refusal(small_), "") << length;
    }
}

TEST_F(StructureFiles, AreRefusedWithAnyByteChanged) {
    const Bytes bytes = saved(small_);
    ASSERT_EQ(refusal(small_), "");
    std::fstream file(file_, std::ios::binary | std::ios::in | std::ios::out);
    const auto put = [&](size_t at, std::byte value) {
        file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(value)).flush();
    };
    for (size_t i = 0; i < bytes.size(); ++i) {
        for (const std::byte change : {std::byte{1}, std::byte{0xff}}) {
            put(i, bytes[i] ^ change);
            ASSERT_NE(refusal(small_), "") << i;
        }
        put(i, bytes[i]);
    }
    EXPECT_EQ(refusal(small_), "");
}

TEST_F(StructureFiles, AreRefusedOverAnotherScene) {
    saved(small_);
    std::vector<Triangle> other = small_;
    other[5].b.y = std::nextafter(other[5].b.y, 10.0f);
    EXPECT_NE(refusal(other).find("another scene"), std::string::npos) << refusal(other);
    other = small_;
    std::swap(other[0], other[1]);
    EXPECT_NE(refusal(other).find("another scene"), std::string::npos);
    other = small_;
    other[5].kind = PrimitiveKind::sphere;
    EXPECT_NE(refusal(other).find("another scene"), std::string::npos);
    other = small_;
    other.pop_back();
    EXPECT_NE(refusal(other).find("24 triangles and spheres; this one has 23"), std::string::npos) << refusal(other);
    EXPECT_NE(refusal(std::vector<Triangle>{}).find("another scene"), std::string::npos);
}

TEST_F(StructureFiles, SayWhatIsWrongWithThem) {
    const Bytes bytes = saved(small_);
    const auto changed = [&](size_t at, std::vector<uint8_t> values) {
        Bytes copy = bytes;
        for (const uint8_t value : values) copy[at++] = std::byte{value};
        write(copy);
        return refusal(small_);
    };
    EXPECT_NE(changed(offsetof(StructureFileHeader, version), {4}).find("version 4"), std::string::npos);
    EXPECT_NE(changed(offsetof(StructureFileHeader, byteOrder), {1, 2, 3, 4}).find("other byte order"), std::string::npos);
    EXPECT_NE(changed(0, {'P', 'N', 'G'}).find("is no structure of raig"), std::string::npos);
    EXPECT_NE(changed(offsetof(StructureFileHeader, nodeTexels), {0, 0, 0, 0, 0, 0, 0, 0xf0}).find("header"),
              std::string::npos);
    EXPECT_NE(changed(bytes.size() - 1, {1}).find("arrays"), std::string::npos);
    fs::remove(file_);
    EXPECT_THROW(StructureFile{file_}, Error);
    EXPECT_THROW(StructureFile{folder_}, Error);
}

TEST_F(StructureFiles, RememberTheOptionsTheyWereBuiltWith) {
    saved(small_, "bvh", {.build = "binned", .walk = "skip", .maxLeaf = 2, .memoryBudget = uint64_t{64} << 20});
    EXPECT_EQ(StructureFile(file_).options(), "--build binned --walk skip --max-leaf 2 --memory-budget 64");
}

// Whether light passes a triangle is said by the scene's materials, which may have changed since.
TEST_F(StructureFiles, ForgetWhatLightPasses) {
    Structure structure = structureType("bvh").build(small_, {});
    structure.markSeeThrough(std::vector<uint8_t>(small_.size(), 1));
    saveStructure(file_, structure, {}, small_);
    structure.markSeeThrough(std::vector<uint8_t>(small_.size(), 0));
    EXPECT_EQ(StructureFile(file_).read(small_).triangles, structure.triangles);
}

TEST_F(StructureFiles, LeaveNothingBehindWhereTheyCannotBeWritten) {
    const Structure structure = structureType("bvh").build(small_, {});
    EXPECT_THROW(saveStructure(folder_ / "no" / "folder", structure, {}, small_), Error);
    EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace raig

// What hard cases ask besides hits: few references, shallow trees, short builds and walks, files refused and pictures made.
#include "measure/ray_sets.hpp"
#include "measure/scene_numbers.hpp"
#include "rays/cpu_walk.hpp"
#include "rays/tracer.hpp"
#include "scene/import.hpp"
#include "structures/structure.hpp"
#include "support/effort.hpp"
#include "support/gltf_asset.hpp"
#include "support/hard_cases.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <iostream>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace raig {
namespace {

std::vector<Hit> trace(const Structure& structure, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    return hits;
}

#ifdef __SSE__
/// Denormals are zeros, as what operations take and as what they give, while this is alive.
class FlushedDenormals {
public:
    FlushedDenormals() { _mm_setcsr(before_ | 0x8040u); }
    ~FlushedDenormals() { _mm_setcsr(before_); }
    FlushedDenormals(const FlushedDenormals&) = delete;
    FlushedDenormals& operator=(const FlushedDenormals&) = delete;

private:
    uint32_t before_ = _mm_getcsr();
};

/// On this thread: others have their own mode.
std::vector<Hit> traceHere(const Structure& structure, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    WalkCounters counters;
    cpuWalk(structure.walkFile())(structure, {}, rays, hits, counters);
    return hits;
}

// Case 10 on processors, or devices, that know no denormals.
TEST(HardCase10, EveryStructureAnswersAsBruteForceWhereDenormalsAreZeros) {
    for (const hard::Scene& scene : test::hardScenes(10)) {
        const Structure brute = structureType("brute").build(scene.triangles, {});
        const std::vector<Hit> kept = trace(brute, scene.rays);
        std::vector<Hit> want;
        {
            const FlushedDenormals flushed;
            want = traceHere(brute, scene.rays);
        }
        for (size_t i = 0; i < want.size(); ++i) EXPECT_EQ(want[i].primitive == NO_HIT, kept[i].primitive == NO_HIT);
        for (const test::Variant& variant : test::walkVariants()) {
            const Structure structure = variant.build(scene.triangles);
            const FlushedDenormals flushed;
            volatile float small = 1e-40f;
            ASSERT_EQ(small * 1.0f, 0.0f);
            const std::vector<Hit> got = traceHere(structure, scene.rays);
            EXPECT_EQ(std::memcmp(got.data(), want.data(), want.size() * sizeof(Hit)), 0) << variant;
        }
    }
}
#endif

// Case 22: whichever copy comes first in the structure, and in space.
TEST(HardCase22, TheLowestOfCopiesIsHit) {
    for (const hard::Scene& scene : test::hardScenes(22)) {
        const auto lowestCopy = [&](uint32_t hit) {
            for (uint32_t i = 0; i < hit; ++i)
                if (std::memcmp(&scene.triangles[i], &scene.triangles[hit], sizeof(Triangle)) == 0) return i;
            return hit;
        };
        for (const test::Variant& variant : test::walkVariants())
            for (const Hit& hit : trace(variant.build(scene.triangles), scene.rays)) {
                ASSERT_NE(hit.primitive, NO_HIT);
                ASSERT_EQ(hit.primitive, lowestCopy(hit.primitive)) << variant;
            }
    }
}

// Cases 23, 42, 44, 45 and 47: where halving space or boxes gains nothing, and must stop. No option is given.
TEST(HardCases23To47, StructuresStaySmallAndShallow) {
    for (const uint32_t number : {23, 42, 44, 45, 47})
        for (const hard::Scene& scene : test::hardScenes(number))
            for (const StructureType& type : structureTypes()) {
                const auto start = std::chrono::steady_clock::now();
                const StructureStatistics built = type.build(scene.triangles, {}).statistics;
                const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
                const double references = double(built.references) / double(scene.triangles.size());
                // Trees that choose their planes put a wall that lies in one on one side of it.
                const bool chooses = type.name == "kdtree" || type.name == "bsp";
                EXPECT_LE(references, number == 47 && chooses ? 1.5 : 20.0) << "case " << number << ", " << type.name;
                EXPECT_LE(built.depth, 65u) << "case " << number << ", " << type.name;
                EXPECT_LT(seconds, 20.0) << "case " << number << ", " << type.name;
                std::cout << fmt::format("case {}, {}: {:.2f} references a triangle, depth {}, {:.3f} s\n", number,
                                         type.name, references, built.depth, seconds);
            }
}

TEST(HardCases23To47, StructuresKeepTheirInvariants) {
    for (const uint32_t number : {44, 45, 47})
        for (const hard::Scene& scene : test::hardScenes(number))
            for (const test::Variant& variant : test::isLong() ? test::allVariants() : test::walkVariants()) {
                const Structure structure = variant.build(scene.triangles);
                EXPECT_EQ(structureType(variant.structure).findFault(structure, scene.triangles), std::nullopt) << variant;
                EXPECT_LE(structure.statistics.depth, 65u) << variant;
            }
}

// Case 25: triangles without an area are left out, and counted.
TEST(HardCase25, TrianglesWithoutAnAreaAreCounted) {
    const Folder folder;
    const Scene scene = importObj(folder.write("flat.obj",
                                               "v 0 0 0\nv 1 1 1\nv 2 2 2\nv 0 1 0\nv 0 0 0\n"
                                               "f 1 2 3\nf 1 1 4\nf 1 5 4\nf 2 2 2\nf 1 2 4\n"));
    const Geometry geometry = flatten(scene);
    EXPECT_EQ(geometry.dropped.zeroArea, 4u);
    EXPECT_EQ(geometry.triangles.size(), 5u);  // numbers stay those of the file
}

ProgramResult raig(const std::vector<std::string>& arguments) {
    return runProgram(RAIG_PROGRAM, arguments);
}

// Case 29: indices that name no vertex are refused, in one line, with exit code 3.
TEST(HardCase29, IndicesOutOfRangeAreRefused) {
    const Folder folder;
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    std::vector<std::filesystem::path> files;
    for (const char* index : {"4", "0", "-4", "2147483648", "4294967295", "99999999999"})
        files.push_back(folder.write(fmt::format("{}.obj", index), vertices + "f 1 2 " + index + "\n"));
    for (const char* index : {"3", "-1", "2147483647", "4294967295"})
        files.push_back(folder.write(fmt::format("{}.ply", index), ply + "3 0 1 " + index + "\n"));
    for (const uint16_t index : {3, 65535}) {
        test::GltfAsset asset;
        const int positions = asset.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
        asset.node(
            {{"mesh", asset.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", asset.indices({0, 1, index})}})}});
        const std::vector<std::byte> bytes = asset.glb();
        files.push_back(
            folder.write(fmt::format("{}.glb", index), {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
    }
    for (const std::filesystem::path& file : files) {
        const ProgramResult result = raig({"info", file.string()});
        EXPECT_EQ(result.exitCode, 3) << file;
        EXPECT_EQ(result.output, "") << file;
        EXPECT_NE(result.errors.find(file.string()), std::string::npos) << result.errors;
    }
}

// Case 30: there is a picture, if of the background only.
TEST(HardCase30, NearlyNothingMakesAPicture) {
    const Folder folder;
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e30 0 0\n";
    const std::pair<const char*, std::string> scenes[] = {{"none.obj", ""},
                                                          {"vertices.obj", vertices},
                                                          {"one.obj", vertices + "f 1 2 3\n"},
                                                          {"invalid.obj", vertices + "f 1 1 2\nf 1 5 2\n"}};
    for (const auto& [name, text] : scenes) {
        const std::string file = folder.write(name, text).string();
        for (const StructureType& type : structureTypes()) {
            const ProgramResult result = raig({"render", file, "-o", file + ".pfm", "--size", "4x4", "--device", "cpu",
                                               "--accel", std::string(type.name), "--quiet"});
            EXPECT_EQ(result.exitCode, 0) << name << ' ' << type.name << ' ' << result.errors;
            EXPECT_TRUE(std::filesystem::exists(file + ".pfm")) << name;
        }
    }
}

// Case 31: what is no ray costs nothing: no node is fetched, no triangle tested.
TEST(HardCase31, RaysThatAreNoneCostNothing) {
    for (const hard::Scene& scene : test::hardScenes(31)) {
        std::vector<Ray> none;
        for (size_t i = 0; i < scene.rays.size(); ++i)
            if (i % 8 != 7) none.push_back(scene.rays[i]);
        std::vector<Hit> hits(none.size());
        for (const test::Variant& variant : test::allVariants()) {
            const Structure structure = variant.build(scene.triangles);
            const WalkCounters counters = makeCpuTracer(structure)->trace(none, hits, Query::closest).counters;
            EXPECT_EQ(counters.nodeFetches, 0u) << variant;
            EXPECT_EQ(counters.triangleTests, 0u) << variant;
            for (const Hit& hit : hits) EXPECT_EQ(hit.primitive, NO_HIT) << variant;
        }
    }
}

// Case 41, on the standard rays of a picture of the whole.
TEST(HardCase41, AGridOfTwoLevelsTestsFewTrianglesInTheStadium) {
    const std::filesystem::path file =
        std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/stadium/house_and_bunny.glb";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
    const Geometry geometry = flatten(importScene(file));
    std::vector<Triangle> triangles;
    for (const uvec3& t : geometry.triangles)
        triangles.push_back({geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]});
    EXPECT_TRUE(measureScene(triangles).isUneven());
    const Structure bvh = structureType("bvh").build(triangles, {});
    const auto bvhTracer = makeCpuTracer(bvh);
    const RaySets sets = makeRaySets(geometry, geometry.bounds, measuringCamera(geometry, geometry.bounds), 128, *bvhTracer);
    std::vector<Ray> rays = sets.primary;
    for (const auto* more : {&sets.diffuse, &sets.specular}) rays.insert(rays.end(), more->begin(), more->end());
    std::vector<Hit> hits(rays.size());
    const auto testsOf = [&](const Structure& structure) {
        const WalkCounters counters = makeCpuTracer(structure)->trace(rays, hits, Query::closest).counters;
        return double(counters.triangleTests) / double(rays.size());
    };
    const double two = testsOf(structureType("grid").build(triangles, {.levels = 2})), best = testsOf(bvh);
    std::cout << fmt::format("case 41: {:.1f} triangles a ray with two levels, {:.1f} with bvh; {} rays\n", two, best,
                             rays.size());
    EXPECT_LE(two, 20.0);
}

}  // namespace
}  // namespace raig

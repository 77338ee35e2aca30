// The walk of bvh over nodes that hold their children's boxes: in pieces, over broken links, and against a full stack.
#include "base/error.hpp"
#include "base/random.hpp"
#include "measure/ray_sets.hpp"
#include "rays/cpu_walk.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"
#include "structures/bvh.hpp"
#include "structures/bvh_trail.hpp"
#include "support/full_stack.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <type_traits>
#include <utility>

namespace raig {

namespace {

using namespace glm;
using namespace shared;

#define COUNT_NODE(did)
#define COUNT_TRIANGLE(did)
#define COUNT_BOXES(count)
#define COUNT_LINK(did)

/// What walks read. Reads out of range are caught.
struct Memory {
    static constexpr bool ANY_HIT = false, SKIP_SEE_THROUGH = false, HAS_SPHERES = true, COUNTING = false;

    explicit Memory(const Structure& structure) : header(structure.header), structure(structure) {}

    uvec4 nodes_at(uint i) const { return structure.nodes.at(i); }
    uvec4 triangles_at(uint i) const { return structure.triangles.at(i); }

    const StructureHeader& header;
    const Structure& structure;

#include "intersect.glsl"
#include "triangles.glsl"
};

/// The walks, with their loop's bound in the caller's hand.
template <uint WALK>
struct Walk2 : Memory {
    using Memory::Memory;
#include "structures/bvh_trail2.glsl"
#include "trace.glsl"
};
#undef TRAIL_ARITY
#undef HAS_WALK
#undef A_WALK

template <uint WALK>
struct Walk4 : Memory {
    using Memory::Memory;
#include "structures/bvh_trail4.glsl"
#include "trace.glsl"
};
#undef TRAIL_ARITY
#undef HAS_WALK
#undef A_WALK

template <uint WALK>
struct Walk8 : Memory {
    using Memory::Memory;
#include "structures/bvh_trail8.glsl"
#include "trace.glsl"
};

#undef COUNT_NODE
#undef COUNT_TRIANGLE
#undef COUNT_BOXES
#undef COUNT_LINK

}  // namespace

namespace {

namespace fs = std::filesystem;
using test::Soup;

/// Hits of walks that stop after every `steps` loop iterations and are taken up again. Nothing if one takes more than
/// `most`.
template <uint32_t walk>
std::optional<std::vector<Hit>> traceInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t steps,
                                              uint64_t most) {
    std::vector<Hit> hits;
    constexpr uint32_t kind = (walk - WALK_TRAIL) % 3;
    std::conditional_t<kind == 0, Walk2<walk>, std::conditional_t<kind == 1, Walk4<walk>, Walk8<walk>>> walker(structure);
    for (const Ray& ray : rays) {
        uvec4 at(0u);
        Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
        uint64_t pieces = 0;
        while (!walker.traceRay(ray, at, steps, hit))
            if (++pieces * steps > most) return std::nullopt;
        hits.push_back(hit);
    }
    return hits;
}

template <class Test, uint32_t... walks>
void forEachOf(const Test& test, std::integer_sequence<uint32_t, walks...>) {
    (test(std::integral_constant<uint32_t, WALK_TRAIL + walks>{}), ...);
}

/// Calls test(walk) for each of the walks: every arity and precision.
template <class Test>
void forEachWalk(const Test& test) {
    forEachOf(test, std::make_integer_sequence<uint32_t, MAX_WALKS - WALK_TRAIL>());
}

BuildParams paramsOf(uint32_t walk) {
    StructureHeader header{};
    header.walk = walk;
    return {.walk = "trail", .arity = bvh::trailArity(header), .precision = bvh::trailPrecision(header)};
}

std::vector<Hit> trace(const Structure& structure, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    return hits;
}

void expectSame(const std::vector<Hit>& got, const std::vector<Hit>& want, const std::vector<Ray>& rays,
                const std::string& what) {
    for (size_t i = 0; i < rays.size(); ++i)
        ASSERT_EQ(std::memcmp(&got[i], &want[i], sizeof(Hit)), 0)
            << what << " ray " << i << ' ' << test::describe(rays[i]) << " got " << got[i].primitive << ' ' << got[i].t
            << " want " << want[i].primitive << ' ' << want[i].t;
}

}  // namespace

TEST(Trail, IsLaidOutAsAskedFor) {
    forEachWalk([](auto walk) {
        const BuildParams params = paramsOf(walk);
        EXPECT_EQ(bvh::trailWalk(params.arity, params.precision), walk);
        const Structure structure = bvh::build(test::sphere(10, 1.0, dvec3(0), 0.1), params);
        EXPECT_EQ(structure.header.walk, walk);
        EXPECT_NE(structure.walk.find(fmt::format("{} boxes, {}-bit", params.arity, params.precision)), std::string::npos);
    });
    EXPECT_TRUE(bvh::isTrail(bvh::build({}, {.precision = 8}).header)) << "the only walk with planes of 8 bits";
    for (const char* walk : {"skip", "octants"}) EXPECT_THROW(bvh::build({}, {.walk = walk, .precision = 8}), Error);
    EXPECT_THROW(bvh::build({}, {.walk = "trail", .bound = "obb"}), Error);
}

// Hard case 60: nothing but `at` and the hit so far is kept from one dispatch to the next.
TEST(Trail, IsWalkedInPiecesOfAnySize) {
    for (const Soup& soup : test::soups()) {
        if (soup.triangles.size() < 2) continue;
        const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 6, 120);
        forEachWalk([&](auto walk) {
            BuildParams params = paramsOf(walk);
            params.build = "median";
            const Structure structure = bvh::build(soup.triangles, params);
            const std::vector<Hit> want = trace(structure, rays);
            for (const uint32_t steps : {1u, 2u, 3u, 7u}) {
                const auto hits = traceInPieces<decltype(walk)::value>(structure, rays, steps, mostStepsOf(structure));
                ASSERT_TRUE(hits) << soup.name << ": a walk does not end";
                expectSame(*hits, want, rays, soup.name + ' ' + structure.walk);
            }
        });
    }
}

// Hard case 62: whatever the links, a walk reads nothing outside its arrays, and ends, unless it goes on beyond what any of
// a sound tree does, which tracers notice.
TEST(Trail, StaysInItsArraysWhateverItsLinks) {
    const std::vector<Triangle> triangles = test::sphere(9, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 7, 60);
    Random random(8);
    forEachWalk([&](auto walk) {
        const Structure sound = bvh::build(triangles, paramsOf(walk));
        for (int trial = 0; trial < 60; ++trial) {
            Structure broken = sound;
            for (uint32_t faults = 1 + random.below(100); faults > 0; --faults) {
                uvec4& node = broken.nodes[random.below(static_cast<uint32_t>(broken.nodes.size()))];
                uint32_t& word = node[static_cast<int>(random.below(4))];
                switch (random.below(4)) {
                    case 0:
                        word = static_cast<uint32_t>(random.bits());
                        break;
                    case 1:
                        word ^= 1u << random.below(32);
                        break;
                    case 2:
                        word = random.below(sound.header.nodeCount + 2);
                        break;
                    default:
                        word = random.below(sound.header.nodeCount) << 3 | random.below(8);
                        break;
                }
            }
            const uint64_t most = mostStepsOf(broken);
            EXPECT_NO_THROW((traceInPieces<decltype(walk)::value>(broken, rays, 1000, most))) << trial << ' ' << sound.walk;
            EXPECT_NO_THROW((traceInPieces<decltype(walk)::value>(broken, rays, 3, most))) << trial << ' ' << sound.walk;
        }
    });
}

// A child that is its own ancestor, and a link that leads elsewhere.
TEST(Trail, RefusesCircles) {
    const std::vector<Triangle> triangles = test::sphere(9, 1.0, dvec3(0), 0.1);
    const Structure sound = bvh::build(triangles, {.walk = "trail", .arity = 2, .precision = 32});
    ASSERT_EQ(bvh::findFault(sound, triangles), std::nullopt);
    Structure broken = sound;
    broken.nodes[4 * 5 + 3].x = 2;
    EXPECT_NE(bvh::findFault(broken, triangles), std::nullopt);
    broken = sound;
    broken.nodes[sound.header.nodeCount * 4 + 1].y ^= 1u;  // of node 5
    EXPECT_NE(bvh::findFault(broken, triangles), std::nullopt);
}

namespace {

struct NamedRays {
    std::string name;
    std::vector<Ray> rays;
    bool bounced;
};

/// Primary rays of small pictures, of the whole scene and by the file's own camera, and a cosine-distributed bounce of each.
std::vector<NamedRays> raysOf(const Scene& scene, const Geometry& geometry, Tracer& tracer) {
    std::vector<MeasuringCamera> cameras = {measuringCamera(geometry, geometry.bounds)};
    const Camera& own = scene.cameras.front();
    if (!own.orthographic)
        cameras.push_back({dvec3(own.eye), dvec3(own.forward), dvec3(own.right), dvec3(own.up), std::tan(0.5 * own.yfov)});
    std::vector<NamedRays> result;
    for (const MeasuringCamera& camera : cameras) {
        RaySets sets = makeRaySets(geometry, geometry.bounds, camera, 160, tracer);
        const std::string from = result.empty() ? "" : " inside";
        result.push_back({"primary" + from, std::move(sets.primary), false});
        result.push_back({"bounce" + from, std::move(sets.diffuse), true});
    }
    return result;
}

/// The scenes that walks and builders are measured in. Empty if they are not here.
std::vector<fs::path> measuredScenes() {
    const fs::path scenes = fs::path(RAIG_SOURCE_DIR) / "../shared/scenes";
    if (!fs::exists(scenes)) return {};
    return {scenes / "meshes/bunny.ply", scenes / "rooms/white_room.glb", scenes / "rooms/classroom.glb",
            scenes / "rooms/fzk_haus.glb"};
}

}  // namespace

TEST(Trail, ReadsHardlyMoreNodesThanAFullStack) {
    if (measuredScenes().empty()) GTEST_SKIP() << "the real scenes (../shared/scenes) are not here";
    for (const fs::path& file : measuredScenes()) {
        const Scene scene = importScene(file);
        const Geometry geometry = flatten(scene);
        const std::vector<Triangle> triangles = primitivesOf(geometry);
        for (const uint32_t arity : {2, 4, 8}) {
            const Structure structure = bvh::build(triangles, {.walk = "trail", .arity = arity, .precision = 32});
            const auto tracer = makeCpuTracer(structure);
            for (const auto& [name, rays, bounced] : raysOf(scene, geometry, *tracer)) {
                ASSERT_GT(rays.size(), 3000u) << file;
                WalkCounters full;
                const std::vector<Hit> want = test::traceWithFullStack(structure, rays, full);
                std::vector<Hit> hits(rays.size());
                const WalkCounters trail = tracer->trace(rays, hits, Query::closest).counters;
                expectSame(hits, want, rays, file.filename().string());
                const auto count = static_cast<double>(rays.size());
                const double factor = static_cast<double>(trail.nodeFetches) / static_cast<double>(full.nodeFetches);
                fmt::print(
                    "{:15} arity {} {:14} nodes {:6.2f}, full stack {:6.2f}: {:.4f}; triangles {:.2f}, {:.2f}; links "
                    "{:.4f}\n",
                    file.filename().string(), arity, name, double(trail.nodeFetches) / count,
                    double(full.nodeFetches) / count, factor, double(trail.triangleTests) / count,
                    double(full.triangleTests) / count, double(trail.linkReads) / count);
                // Of four places on the stack, a wide node takes up to three or four at once.
                EXPECT_LE(factor, bounced && arity == 2 ? 1.03 : 1.10) << file << " arity " << arity << ' ' << name;
                // Children entered at nearly equal distances may take turns: that much luck there may be.
                EXPECT_GE(factor, 0.99) << "a full stack reads the fewest";
                EXPECT_NEAR(double(trail.triangleTests) / double(full.triangleTests), 1.0, 0.01)
                    << file << " arity " << arity << ' ' << name;
            }
        }
    }
}

// Bins find nearly as good splits as trying every place does; spatial splits find better ones where triangles are long.
TEST(Builders, ComeNearTheBestThatSplittingCentroidsCanDo) {
    if (measuredScenes().empty()) GTEST_SKIP() << "the real scenes (../shared/scenes) are not here";
    for (const fs::path& file : measuredScenes()) {
        const std::vector<Triangle> triangles = primitivesOf(flatten(importScene(file)));
        const auto cost = [&](const char* build) {
            return bvh::build(triangles, {.build = build, .walk = "trail", .arity = 2, .precision = 32}).statistics.sahCost;
        };
        const double sweep = cost("sweep"), binned = cost("binned");
        fmt::print("{:15} SAH cost: sweep {:.3f}, binned {:.3f} ({:.4f})\n", file.filename().string(), sweep, binned,
                   binned / sweep);
        EXPECT_LE(sweep, binned) << file;
        EXPECT_LE(binned, 1.05 * sweep) << file;
        if (file.filename() != "white_room.glb") continue;
        const double spatial = cost("sbvh");
        fmt::print("{:15} SAH cost: sbvh {:.3f}\n", file.filename().string(), spatial);
        EXPECT_LT(spatial, sweep) << file;
    }
}

}  // namespace raig

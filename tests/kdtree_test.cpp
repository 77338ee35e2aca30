// What is peculiar to kd-trees: planes, budgets, links; and the walk one loop iteration at a time.
#include "structures/kdtree.hpp"

#include "base/error.hpp"
#include "base/random.hpp"
#include "rays/cpu_walk.hpp"
#include "structures/kdtree_tree.hpp"
#include "support/cells.hpp"
#include "support/effort.hpp"
#include "support/tracing.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

namespace raig {

namespace {

using namespace glm;
using namespace shared;

#define COUNT_NODE(did)
#define COUNT_TRIANGLE(did)

/// The walk, with its loop's bound in the caller's hand. Reads out of range are caught.
template <uint WALK>
struct Walk {
    static constexpr bool ANY_HIT = false, SKIP_SEE_THROUGH = false, HAS_SPHERES = true;

    explicit Walk(const Structure& structure) : header(structure.header), structure(structure) {}

    uvec4 nodes_at(uint i) const { return structure.nodes.at(i); }
    uvec4 triangles_at(uint i) const { return structure.triangles.at(i); }

    const StructureHeader& header;
    const Structure& structure;

#include "intersect.glsl"
#include "triangles.glsl"
// Between these two, as where they are compiled for use.
#include "structures/kdtree.glsl"
#include "trace.glsl"
};

#undef COUNT_NODE
#undef COUNT_TRIANGLE

}  // namespace

namespace {

using test::AxisPlane;
using test::expectSame;
using test::Soup;
using test::traceOnCpu;

Structure build(const std::vector<Triangle>& triangles, const BuildParams& params = {}) {
    return kdtree::build(triangles, params);
}

std::vector<AxisPlane> planesOf(const Structure& structure) {
    std::vector<AxisPlane> planes;
    for (uint32_t i = 0; i < structure.header.nodeCount; ++i) {
        const uvec4& node = structure.nodes[kdtree::rootNode + i];
        planes.push_back({static_cast<int>(node.y), std::bit_cast<float>(node.x) / structure.header.unit});
    }
    return planes;
}

/// Hits of walks that stop after every `steps` loop iterations and are taken up again. Nothing if one takes more than
/// `most`.
template <uint32_t walk>
std::optional<std::vector<Hit>> traceInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t steps,
                                              uint32_t most) {
    std::vector<Hit> hits;
    Walk<walk> walker(structure);
    for (const Ray& ray : rays) {
        uvec4 at(0u);
        Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
        uint32_t pieces = 0;
        while (!walker.traceRay(ray, at, steps, hit))
            if (++pieces * steps > most) return std::nullopt;
        hits.push_back(hit);
    }
    return hits;
}

}  // namespace

// Hard cases 47, 48, 49: triangles in the planes; rays in them; t of a plane equal to tMin or tMax; origins on planes.
TEST(KdTree, FindsWhatBruteForceFindsAtItsPlanes) {
    for (const Soup& soup : test::soups())
        for (const char* builder : {"sah", "median"}) {
            const Structure structure = build(soup.triangles, {.build = builder});
            if (structure.header.nodeCount == 0) continue;
            const std::vector<Ray> rays =
                test::raysAtPlanes(soup.triangles, planesOf(structure), /* seed= */ 3, test::affordable(1600));
            expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
                       soup.name + ' ' + builder);
        }
}

// Hard case 47: flat triangles in a plane go to one side of it, and cells around them are cut off: nothing is doubled.
TEST(KdTree, RefersOnceToWallsThatItsPlanesLieIn) {
    std::vector<Triangle> walls;
    for (int axis = 0; axis < 3; ++axis)
        for (int layer = 0; layer < 5; ++layer)
            for (int i = 0; i < 8; ++i) {
                const auto at = [&](int k, int l) {
                    vec3 p(static_cast<float>(layer));
                    p[(axis + 1) % 3] = static_cast<float>(k);
                    p[(axis + 2) % 3] = static_cast<float>(l);
                    return p;
                };
                walls.push_back({at(i, 0), at(i + 1, 0), at(i + 1, 1)});
                walls.push_back({at(i, 0), at(i + 1, 1), at(i, 1)});
            }
    const Structure structure = build(walls);
    EXPECT_EQ(kdtree::findFault(structure, walls), std::nullopt);
    EXPECT_LE(structure.statistics.references, walls.size() * 3 / 2);
}

// Hard cases 23, 44, 45.
TEST(KdTree, RefersAtMostTwentyTimesToEachTriangle) {
    for (const Soup& soup : test::growingSoups())
        for (const char* builder : {"sah", "median"}) {
            const Structure structure = build(soup.triangles, {.build = builder});
            EXPECT_EQ(kdtree::findFault(structure, soup.triangles), std::nullopt) << soup.name;
            EXPECT_LE(structure.statistics.references, 20 * soup.triangles.size()) << soup.name << ' ' << builder;
            const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 5, test::affordable(1000));
            expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
                       soup.name);
        }
}

TEST(KdTree, HoldsTrianglesThatAreNearlyFlat) {
    const Soup soup = test::nearlyFlatSoup();
    const Structure structure = build(soup.triangles);
    EXPECT_EQ(kdtree::findFault(structure, soup.triangles), std::nullopt);
    std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 5, 2000);
    const std::vector<Ray> more = test::raysAtPlanes(soup.triangles, planesOf(structure), /* seed= */ 5, 2000);
    rays.insert(rays.end(), more.begin(), more.end());
    expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
               soup.name);
}

// Hard case 60: nothing but `at` and the hit so far is kept from one dispatch to the next.
TEST(KdTree, IsWalkedInPiecesOfAnySize) {
    for (const Soup& soup : test::soups()) {
        if (soup.triangles.size() < 2) continue;
        const Structure structure = build(soup.triangles, {.build = "median", .maxLeaf = 8});
        const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 6, 400);
        const std::vector<Hit> want = traceOnCpu(structure, rays);
        for (const uint32_t steps : {1u, 2u, 7u}) {
            const auto restart = traceInPieces<WALK_RESTART>(structure, rays, steps, 1u << 20);
            const auto stack = traceInPieces<WALK_SHORT_STACK>(structure, rays, steps, 1u << 20);
            ASSERT_TRUE(restart && stack) << soup.name << ": a walk does not end";
            expectSame(*restart, want, rays, soup.name + " restart");
            expectSame(*stack, want, rays, soup.name + " short-stack");
        }
    }
}

// Hard case 62: whatever the links, a walk reads nothing outside its arrays, and ends, unless it goes on beyond what any of
// a sound tree does, which tracers notice.
TEST(KdTree, StaysInItsArraysWhateverItsLinks) {
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const Structure sound = build(triangles);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 7, 200);
    Random random(8);
    for (int trial = 0; trial < 200; ++trial) {
        Structure broken = sound;
        for (uint32_t faults = 1 + random.below(200); faults > 0; --faults) {
            uvec4& node = broken.nodes[1 + random.below(static_cast<uint32_t>(broken.nodes.size() - 1))];
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
                    word = kdtree::leafBit | random.below(sound.nodes[0].y);
                    break;
            }
        }
        const auto most = static_cast<uint32_t>(mostStepsOf(broken));
        EXPECT_NO_THROW((traceInPieces<WALK_RESTART>(broken, rays, 1000, most))) << trial;
        EXPECT_NO_THROW((traceInPieces<WALK_SHORT_STACK>(broken, rays, 1000, most))) << trial;
    }
}

struct WordAndCell {
    uint32_t at;
    Box cell;
};

/// The words of all lists below a child's word, and the cells that they are of.
void listWords(const Structure& structure, uint32_t word, const Box& cell, std::vector<WordAndCell>& words) {
    if (word == kdtree::emptyCell) return;
    if ((word & kdtree::leafBit) != 0) {
        for (uint32_t at = word & ~kdtree::leafBit;; ++at) {
            words.push_back({at, cell});
            if ((structure.nodes[at / 4][static_cast<int>(at % 4)] & kdtree::lastBit) != 0) return;
        }
    }
    const uvec4 node = structure.nodes[word];
    Box below = cell, above = cell;
    below.hi[static_cast<int>(node.y)] = above.lo[static_cast<int>(node.y)] = std::bit_cast<float>(node.x);
    listWords(structure, node.z, below, words);
    listWords(structure, node.w, above, words);
}

/// True if one of some points of the triangle lies inside the box, away from its sides.
bool hasPointInside(const Triangle& t, const Box& box) {
    constexpr int n = 20;
    const vec3 margin(1e-5f);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j) {
            const vec3 p = (float(i) * t.a + float(j) * t.b + float(n - i - j) * t.c) / float(n);
            if (all(lessThan(box.lo + margin, p)) && all(lessThan(p, box.hi - margin))) return true;
        }
    return false;
}

TEST(KdTree, NamesItsFaults) {
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const Structure sound = build(triangles);
    ASSERT_EQ(kdtree::findFault(sound, triangles), std::nullopt);
    const auto expectFault = [&](const char* what, auto plant) {
        Structure broken = sound;
        plant(broken);
        EXPECT_NE(kdtree::findFault(broken, triangles), std::nullopt) << what;
    };
    const uint32_t end = sound.nodes[0].x;
    const auto innerChild = [&](const uvec4& node) { return (node.z & kdtree::leafBit) == 0 ? 2 : 3; };
    expectFault("a link to the node itself", [&](Structure& s) { s.nodes[1][innerChild(s.nodes[1])] = 1; });
    expectFault("a link beyond the nodes", [&](Structure& s) { s.nodes[1][innerChild(s.nodes[1])] = end; });
    expectFault("a cell that is forgotten", [&](Structure& s) { s.nodes[1][innerChild(s.nodes[1])] = kdtree::emptyCell; });
    expectFault("a plane outside its cell", [](Structure& s) { s.nodes[1].x = std::bit_cast<uint32_t>(3.0f); });
    expectFault("a plane that is moved",
                [](Structure& s) { s.nodes[1].x = std::bit_cast<uint32_t>(std::bit_cast<float>(s.nodes[1].x) + 0.125f); });
    expectFault("an axis that there is not", [](Structure& s) { s.nodes[1].y = 3; });
    expectFault("a list that runs on", [&](Structure& s) {
        for (size_t i = end; i < s.nodes.size(); ++i) s.nodes[i] &= ~kdtree::lastBit;
    });
    expectFault("other corners", [](Structure& s) { s.triangles[0].x ^= 1; });
    expectFault("another id", [](Structure& s) { s.triangles[0].w = s.triangles[3].w; });
    expectFault("a triangle too few", [](Structure& s) { s.triangles.resize(s.triangles.size() - 3); });
    expectFault("other bounds", [](Structure& s) { s.header.hi.x *= 0.5f; });
    // Where a point of a triangle lies well inside a cell, the reference to it there cannot be another.
    std::vector<WordAndCell> words;
    listWords(sound, kdtree::rootNode, {sound.header.lo, sound.header.hi}, words);
    size_t planted = 0;
    for (const auto& [at, cell] : words) {
        const uint32_t entry = sound.nodes[at / 4][static_cast<int>(at % 4)], place = entry & ~kdtree::lastBit;
        if (!hasPointInside(referencedPrimitive(sound, place), cell)) continue;
        ++planted;
        expectFault("a reference to another triangle", [&, at = at](Structure& s) {
            s.nodes[at / 4][static_cast<int>(at % 4)] = (entry & kdtree::lastBit) | ((place + 1) % s.header.triangleCount);
        });
    }
    EXPECT_GT(planted, words.size() / 2);
}

// A sound tree by hand: the halves of a triangle above and below a plane that it nearly lies in are in one leaf each.
TEST(KdTree, FindsNoFaultWhereATriangleIsCutThatIsNearlyFlat) {
    constexpr float y = 0x1p-42f;
    const std::vector<Triangle> triangles = {{vec3(0, -y, 0), vec3(1, y, 0), vec3(1, y, 1)}};
    Structure structure;
    structure.header = emptyHeader();
    structure.header.lo = vec3(0, -y, 0);
    structure.header.hi = vec3(1, y, 1);
    structure.header.nodeCount = 3;
    structure.header.triangleCount = 1;
    structure.triangles.resize(3);
    writeReference(structure.triangles, 0, triangles[0], 0, 1.0f);
    const auto middle = std::bit_cast<uint32_t>(0.5f);
    structure.nodes = {{4, 18, 0, 0},
                       {0, 1, 2, 3},
                       {middle, 0, kdtree::leafBit | 16, kdtree::emptyCell},
                       {middle, 0, kdtree::emptyCell, kdtree::leafBit | 17},
                       {kdtree::lastBit, kdtree::lastBit, 0, 0}};
    EXPECT_EQ(kdtree::findFault(structure, triangles), std::nullopt);
    structure.nodes[2].z = kdtree::leafBit | 17;
    structure.nodes[3].w = kdtree::leafBit | 16;
    EXPECT_EQ(kdtree::findFault(structure, triangles), std::nullopt);
    std::swap(structure.nodes[2].z, structure.nodes[2].w);
    EXPECT_NE(kdtree::findFault(structure, triangles), std::nullopt);
}

TEST(KdTree, ObeysTheMemoryBudget) {
    const std::vector<Triangle> triangles = test::sphere(60, 1.0, dvec3(0), 0.1);
    const Structure whole = build(triangles);
    const uint64_t least = triangles.size() * 52 + 48;
    uint64_t before = 0;
    for (const uint64_t budget : {least, least + 1000, least * 9 / 8, least * 3 / 2, whole.statistics.bytes * 2}) {
        const Structure structure = build(triangles, {.memoryBudget = budget});
        EXPECT_LE(structure.nodes.size() * 16 + structure.triangles.size() * 16, budget);
        EXPECT_EQ(kdtree::findFault(structure, triangles), std::nullopt) << budget;
        EXPECT_GE(structure.statistics.bytes, before);
        before = structure.statistics.bytes;
    }
    EXPECT_THROW(build(triangles, {.memoryBudget = least - 1}), Error);
}

TEST(KdTree, ObeysItsOptions) {
    const std::vector<Triangle> triangles = test::sphere(30, 1.0, dvec3(0), 0.1);
    for (const uint32_t depth : {1u, 3u, 10u}) {
        const Structure structure = build(triangles, {.maxLeaf = 1, .maxTreeDepth = depth});
        EXPECT_LE(structure.statistics.depth, depth + 1);
        EXPECT_EQ(kdtree::findFault(structure, triangles), std::nullopt);
    }
    EXPECT_GT(build(triangles, {.maxLeaf = 1}).statistics.leaves, build(triangles, {.maxLeaf = 20}).statistics.leaves);
    EXPECT_THROW(build({}, {.build = "binned"}), Error);
    EXPECT_THROW(build({}, {.walk = "octants"}), Error);
    EXPECT_THROW(build({}, {.maxTreeDepth = 65}), Error);
    EXPECT_THROW(build({}, {.levels = 2}), Error);
}

TEST(KdTree, IsCheaperByTheHeuristicThanByTheMedian) {
    for (const Soup& soup : test::soups())
        EXPECT_LE(build(soup.triangles).statistics.sahCost, build(soup.triangles, {.build = "median"}).statistics.sahCost)
            << soup.name;
}

// The planes among bins are nearly as good as the best ones.
TEST(KdTree, LosesLittleByBinning) {
    const std::vector<Triangle> triangles = test::sphere(100, 1.0, dvec3(0), 0.3);
    std::vector<BoxReference> references;
    Box cell;
    for (size_t i = 0; i < triangles.size(); ++i) {
        const Box box = triangles[i].box();
        references.push_back({box.lo, static_cast<uint32_t>(i), box.hi, 0});
        cell.grow(box);
    }
    kdtree::TreeParams params;
    params.mostAdded = 15 * triangles.size();
    params.mostWords = 1u << 30;
    params.exactSize = 512;
    const double binned = kdtree::buildTree(triangles, references, cell, params).cost;
    params.exactSize = triangles.size() * 100;
    const double exact = kdtree::buildTree(triangles, references, cell, params).cost;
    EXPECT_LE(binned, 1.02 * exact);
}

}  // namespace raig

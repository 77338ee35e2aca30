// What is peculiar to octrees: planes, budgets, links; and the walk one loop iteration at a time.
#include "structures/octree.hpp"

#include "base/error.hpp"
#include "base/random.hpp"
#include "rays/cpu_walk.hpp"
#include "support/cells.hpp"
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
#include "structures/octree.glsl"
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
    return octree::build(triangles, params);
}

/// The planes across the middles of all cells, down to the fourth level.
std::vector<AxisPlane> planesOf(const Structure& structure) {
    std::vector<AxisPlane> planes;
    for (int axis = 0; axis < 3; ++axis)
        for (uint32_t i = 0; i <= 16; ++i)
            planes.push_back(
                {axis, octree::planeAt(structure.header, i * (octree::side / 16), axis) / structure.header.unit});
    return planes;
}

/// Hits of walks that stop after every `steps` loop iterations and are taken up again. Nothing if one takes more than
/// `most`.
std::optional<std::vector<Hit>> traceInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t steps,
                                              uint32_t most) {
    std::vector<Hit> hits;
    Walk walker(structure);
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

// Hard cases 32 to 36, 49: origins, targets and ends of intervals on faces and corners of cells; rays in faces; from far
// away.
TEST(Octree, FindsWhatBruteForceFindsAtItsPlanes) {
    for (const Soup& soup : test::soups()) {
        const Structure structure = build(soup.triangles);
        if (structure.header.nodeCount == 0) continue;
        const std::vector<Ray> rays = test::raysAtPlanes(soup.triangles, planesOf(structure), /* seed= */ 3, 1600);
        expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
                   soup.name);
    }
}

// Hard cases 23, 44, 45.
TEST(Octree, RefersAtMostTwentyTimesToEachTriangle) {
    for (const Soup& soup : test::growingSoups()) {
        const Structure structure = build(soup.triangles);
        EXPECT_EQ(octree::findFault(structure, soup.triangles), std::nullopt) << soup.name;
        EXPECT_LE(structure.statistics.references, 20 * soup.triangles.size()) << soup.name;
        const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 5, 1000);
        expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
                   soup.name);
    }
}

// Hard case 43: a scene without extent along an axis; a triangle alone.
TEST(Octree, HoldsFlatScenes) {
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Triangle> floor;
        for (int i = 0; i < 20; ++i)
            for (int j = 0; j < 20; ++j) {
                const auto at = [&](int k, int l) {
                    vec3 p(0.0f);
                    p[axis] = 0.7f;
                    p[(axis + 1) % 3] = 0.1f * static_cast<float>(k);
                    p[(axis + 2) % 3] = 0.1f * static_cast<float>(l);
                    return p;
                };
                floor.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            }
        const Structure structure = build(floor);
        EXPECT_EQ(octree::findFault(structure, floor), std::nullopt);
        EXPECT_GT(structure.statistics.leaves, 50u);
        const std::vector<Ray> rays = test::rays(floor, /* seed= */ 5, 2000);
        expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(floor, {}), rays), rays, "floor");
    }
}

TEST(Octree, HoldsTrianglesThatAreNearlyFlat) {
    const Soup soup = test::nearlyFlatSoup();
    const Structure structure = build(soup.triangles);
    EXPECT_EQ(octree::findFault(structure, soup.triangles), std::nullopt);
    std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 5, 2000);
    const std::vector<Ray> more = test::raysAtPlanes(soup.triangles, planesOf(structure), /* seed= */ 5, 2000);
    rays.insert(rays.end(), more.begin(), more.end());
    expectSame(traceOnCpu(structure, rays), traceOnCpu(structureType("brute").build(soup.triangles, {}), rays), rays,
               soup.name);
}

// Hard case 60: nothing but `at` and the hit so far is kept from one dispatch to the next.
TEST(Octree, IsWalkedInPiecesOfAnySize) {
    for (const Soup& soup : test::soups()) {
        if (soup.triangles.size() < 2) continue;
        const Structure structure = build(soup.triangles, {.maxLeaf = 2});
        const std::vector<Ray> rays = test::rays(soup.triangles, /* seed= */ 6, 400);
        const std::vector<Hit> want = traceOnCpu(structure, rays);
        for (const uint32_t steps : {1u, 2u, 7u}) {
            const auto got = traceInPieces(structure, rays, steps, 1u << 20);
            ASSERT_TRUE(got) << soup.name << ": a walk does not end";
            expectSame(*got, want, rays, soup.name);
        }
    }
}

// Hard case 62: whatever the links, a walk reads nothing outside its arrays, and ends, unless it goes on beyond what any of
// a sound tree does, which tracers notice.
TEST(Octree, StaysInItsArraysWhateverItsLinks) {
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const Structure sound = build(triangles);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 7, 100);
    Random random(8);
    for (int trial = 0; trial < 100; ++trial) {
        Structure broken = sound;
        for (uint32_t faults = 1 + random.below(200); faults > 0; --faults) {
            uvec4& record = broken.nodes[1 + random.below(static_cast<uint32_t>(broken.nodes.size() - 1))];
            uint32_t& word = record[static_cast<int>(random.below(4))];
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
                    word = octree::leafBit | random.below(sound.nodes[0].y);
                    break;
            }
        }
        EXPECT_NO_THROW((traceInPieces(broken, rays, 1000, static_cast<uint32_t>(mostStepsOf(broken))))) << trial;
    }
}

/// The words of all lists below a record, and the cells that they are of.
struct WordAndCell {
    uint32_t at;
    Box cell;
};

void listWords(const Structure& structure, uint32_t index, uvec3 low, uint32_t width, std::vector<WordAndCell>& words) {
    const uvec4 record = structure.nodes[index];
    if ((record.x & octree::leafBit) != 0) {
        Box cell;
        for (int axis = 0; axis < 3; ++axis) {
            cell.lo[axis] = octree::planeAt(structure.header, low[axis], axis);
            cell.hi[axis] = octree::planeAt(structure.header, low[axis] + width, axis);
        }
        for (uint32_t at = record.x & ~octree::leafBit;; ++at) {
            words.push_back({at, cell});
            if ((structure.nodes[at / 4][static_cast<int>(at % 4)] & octree::lastBit) != 0) return;
        }
    }
    for (uint32_t octant = 0, child = record.x; octant < 8; ++octant)
        if ((record.y >> octant & 1) != 0)
            listWords(structure, child++, low + width / 2 * uvec3(octant & 1, octant >> 1 & 1, octant >> 2), width / 2,
                      words);
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

TEST(Octree, NamesItsFaults) {
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const Structure sound = build(triangles);
    ASSERT_EQ(octree::findFault(sound, triangles), std::nullopt);
    const auto expectFault = [&](const char* what, auto plant) {
        Structure broken = sound;
        plant(broken);
        EXPECT_NE(octree::findFault(broken, triangles), std::nullopt) << what;
    };
    expectFault("a link to the record itself", [](Structure& s) { s.nodes[1].x = 1; });
    expectFault("a link beyond the records", [](Structure& s) { s.nodes[1].x = s.nodes[0].x; });
    expectFault("an octant that is forgotten", [](Structure& s) { s.nodes[1].y &= s.nodes[1].y - 1; });
    expectFault("no octants", [](Structure& s) { s.nodes[1].y = 0; });
    expectFault("two octants confused", [](Structure& s) { std::swap(s.nodes[2], s.nodes[3]); });
    expectFault("lists that run on", [](Structure& s) {
        for (size_t i = s.nodes[0].x; i < s.nodes.size(); ++i) s.nodes[i] &= ~octree::lastBit;
    });
    expectFault("a smaller cube", [](Structure& s) { s.header.gridStep *= 0.5f; });
    expectFault("a larger cube", [](Structure& s) { s.header.gridStep *= 1.1f; });
    expectFault("other corners", [](Structure& s) { s.triangles[0].x ^= 1; });
    expectFault("another id", [](Structure& s) { s.triangles[0].w = s.triangles[3].w; });
    expectFault("a triangle too few", [](Structure& s) { s.triangles.resize(s.triangles.size() - 3); });
    expectFault("other bounds", [](Structure& s) { s.header.hi.x *= 0.5f; });
    // Where a point of a triangle lies well inside a cell, the reference to it there cannot be another.
    std::vector<WordAndCell> words;
    listWords(sound, octree::rootRecord, uvec3(0), octree::side, words);
    ASSERT_EQ(words.size(), sound.statistics.references);
    size_t planted = 0;
    for (const auto& [at, cell] : words) {
        const uint32_t entry = sound.nodes[at / 4][static_cast<int>(at % 4)], place = entry & ~octree::lastBit;
        if (!hasPointInside(referencedPrimitive(sound, place), cell)) continue;
        ++planted;
        expectFault("a reference to another triangle", [&, at = at](Structure& s) {
            s.nodes[at / 4][static_cast<int>(at % 4)] = (entry & octree::lastBit) | ((place + 1) % s.header.triangleCount);
        });
    }
    EXPECT_GT(planted, words.size() / 3);
}

TEST(Octree, ObeysTheMemoryBudget) {
    const std::vector<Triangle> triangles = test::sphere(60, 1.0, dvec3(0), 0.1);
    const Structure whole = build(triangles);
    const uint64_t least = triangles.size() * 52 + 48;
    uint64_t before = 0;
    for (const uint64_t budget : {least, least + 1000, least * 9 / 8, least * 3 / 2, whole.statistics.bytes * 2}) {
        const Structure structure = build(triangles, {.memoryBudget = budget});
        EXPECT_LE(structure.nodes.size() * 16 + structure.triangles.size() * 16, budget);
        EXPECT_EQ(octree::findFault(structure, triangles), std::nullopt) << budget;
        EXPECT_GE(structure.statistics.bytes, before);
        before = structure.statistics.bytes;
    }
    EXPECT_THROW(build(triangles, {.memoryBudget = least - 1}), Error);
}

// MAX_OBJ and MAX_DEPTH.
TEST(Octree, ObeysItsOptions) {
    const std::vector<Triangle> triangles = test::sphere(30, 1.0, dvec3(0), 0.1);
    for (const uint32_t depth : {1u, 3u, 5u, 20u}) {
        const Structure structure = build(triangles, {.maxLeaf = 1, .maxTreeDepth = depth});
        EXPECT_LE(structure.statistics.depth, depth + 1);
        EXPECT_EQ(octree::findFault(structure, triangles), std::nullopt);
    }
    EXPECT_EQ(build(triangles, {.maxLeaf = 1, .maxTreeDepth = 3}).statistics.depth, 4u);
    EXPECT_GT(build(triangles, {.maxLeaf = 1}).statistics.leaves, build(triangles, {.maxLeaf = 20}).statistics.leaves);
    EXPECT_THROW(build({}, {.build = "sah"}), Error);
    EXPECT_THROW(build({}, {.walk = "restart"}), Error);
    EXPECT_THROW(build({}, {.maxTreeDepth = 21}), Error);
}

}  // namespace raig

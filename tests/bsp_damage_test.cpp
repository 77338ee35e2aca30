// Bsps whose walk is interrupted, or whose arrays are damaged: a walk goes on, ends, and faults are found.
#include "structures/bsp.hpp"

#include "base/random.hpp"
#include "rays/cpu_walk.hpp"
#include "structures/bsp_plane.hpp"
#include "support/soups.hpp"
#include "support/tracing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>

namespace raig {
namespace {

using namespace test;

namespace walks {

using namespace glm;
using namespace shared;

#define COUNT_NODE(did) (void)(did);
#define COUNT_TRIANGLE(did) (void)(did);

/// The walk, to be interrupted at will, over nodes that may be garbage.
struct Bsp {
    static constexpr bool ANY_HIT = false, SKIP_SEE_THROUGH = false, HAS_SPHERES = true;
    explicit Bsp(const Structure& structure) : header(structure.header), structure(structure) {}

    uvec4 nodes_at(uint i) const { return structure.nodes.at(i); }
    uvec4 triangles_at(uint i) const { return structure.triangles[i % structure.triangles.size()]; }

    const StructureHeader& header;
    const Structure& structure;

#include "intersect.glsl"
#include "structures/bsp.glsl"
#include "trace.glsl"
#include "triangles.glsl"
};

}  // namespace walks

bool isInner(const uvec4& node) {
    return (node.w & bsp::leafBit) == 0;
}

// Interrupted after every step, and taken up again with nothing but `at` and the best hit: the same answer.
TEST(Bsp, IsTakenUpAgainAfterAnyStep) {
    for (const char* name : {"ordinary", "duplicates", "overlapping", "pages", "two of each"}) {
        const std::vector<Triangle> triangles = soupNamed(name);
        for (const uint32_t levels : {0u, 4u}) {
            const Structure structure = bsp::build(triangles, {.maxTreeDepth = levels});
            const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 12, /* count= */ 300);
            const std::vector<Hit> want = traceOnCpu(structure, rays);
            walks::Bsp walk(structure);
            Random random(2);
            for (size_t i = 0; i < rays.size(); ++i) {
                uvec4 at(0u);
                Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
                // One step does not get a walk beyond the first levels: it must be let go down to where it was.
                uint32_t steps = 64;
                while (!walk.traceRay(rays[i], at, steps + random.below(3), hit)) ASSERT_LT(++steps, 1u << 20) << name;
                ASSERT_EQ(std::memcmp(&hit, &want[i], sizeof(Hit)), 0) << name << ' ' << test::describe(rays[i]);
            }
        }
    }
}

// Hard case 62: whatever the nodes say, a walk ends.
TEST(Bsp, StaysInTheArraysOfCorruptedTrees) {
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const Structure good = bsp::build(triangles, {});
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 4, /* count= */ 40);
    Random random(9);
    for (int round = 0; round < 200; ++round) {
        Structure bad = good;
        for (int change = 0; change < 30; ++change) {
            uvec4& node = bad.nodes[random.below(static_cast<uint32_t>(bad.nodes.size()))];
            uint32_t& word = node[static_cast<int>(random.below(4))];
            word = random.below(2) == 0 ? word ^ (1u << random.below(32)) : static_cast<uint32_t>(random.bits());
        }
        walks::Bsp walk(bad);
        for (const Ray& ray : rays) {
            uvec4 at(0u);
            Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
            EXPECT_NO_THROW(walk.traceRay(ray, at, static_cast<uint32_t>(mostStepsOf(bad)), hit)) << round;
        }
    }
}

template <class Condition>
uint32_t findNode(const Structure& structure, const Condition& condition) {
    for (uint32_t i = 0; i < structure.nodes.size(); ++i)
        if (condition(structure.nodes[i])) return i;
    ADD_FAILURE() << "no such node";
    return 0;
}

TEST(Bsp, FindsPlantedFaults) {
    const std::vector<Triangle> triangles = soupNamed("overlapping");
    const Structure good = bsp::build(triangles, {.maxTreeDepth = 9});
    ASSERT_EQ(bsp::findFault(good, triangles), std::nullopt);
    const auto isShort = [](const uvec4& n) { return !isInner(n) && (n.w & bsp::moreBit) == 0 && (n.w & 3) == 2; };
    const auto isLinked = [](const uvec4& n) { return !isInner(n) && (n.w & bsp::linkedBit) != 0; };
    const auto hasBoth = [](const uvec4& n) { return isInner(n) && (n.w & (bsp::noBelowBit | bsp::noAboveBit)) == 0; };
    const std::pair<const char*, std::function<void(Structure&)>> faults[] = {
        {"a reference left out", [&](Structure& s) { s.nodes[findNode(s, isShort)].w -= 1; }},
        {"a leaf emptied", [&](Structure& s) { s.nodes[findNode(s, isShort)].w -= 2; }},
        {"a reference twice",
         [&](Structure& s) {
             auto& n = s.nodes[findNode(s, isShort)];
             n.y = n.x;
         }},
        {"a reference out of range", [&](Structure& s) { s.nodes[findNode(s, isShort)].x = s.header.triangleCount; }},
        {"a leaf cut short", [&](Structure& s) { s.nodes[findNode(s, isLinked)].w &= ~(bsp::moreBit | bsp::linkedBit); }},
        {"a leaf that goes on in itself",
         [&](Structure& s) {
             const uint32_t i = findNode(s, isLinked);
             s.nodes[i].z = i;
         }},
        {"a leaf that goes on in the root", [&](Structure& s) { s.nodes[findNode(s, isLinked)].z = 0; }},
        {"a link beyond the end", [&](Structure& s) { s.nodes[findNode(s, isLinked)].z = s.header.nodeCount; }},
        {"children swapped",
         [&](Structure& s) {
             const uint32_t c = s.nodes[findNode(s, hasBoth)].w;
             std::swap(s.nodes[c], s.nodes[c + 1]);
         }},
        {"a child forgotten", [&](Structure& s) { s.nodes[findNode(s, hasBoth)].w |= bsp::noBelowBit; }},
        {"a child that is its parent",
         [&](Structure& s) {
             const uint32_t i = findNode(s, hasBoth);
             s.nodes[i].w = i;
         }},
        {"a child beyond the end", [&](Structure& s) { s.nodes[findNode(s, hasBoth)].w = s.header.nodeCount - 1; }},
        {"the other's child",
         [&](Structure& s) { s.nodes[s.nodes[0].w & bsp::indexBits].w = s.nodes[(s.nodes[0].w & bsp::indexBits) + 1].w; }},
        {"a plane moved",
         [&](Structure& s) { s.nodes[0].z = std::bit_cast<uint32_t>(std::bit_cast<float>(s.nodes[0].z) * 0.9f); }},
        {"a plane moved far away", [&](Structure& s) { s.nodes[0].z = std::bit_cast<uint32_t>(1e9f); }},
        {"a plane that is none", [&](Structure& s) { s.nodes[0].z = 0x7fc00000; }},
        {"a plane turned over",
         [&](Structure& s) {
             bsp::Plane p = bsp::Plane::decoded(s.nodes[0]);
             for (int32_t& step : p.steps) step = std::min(-step, (1 << 20) - 1);
             p.distance = -p.distance;
             s.nodes[0] = p.encoded(s.nodes[0].w);
         }},
        {"a normal too long",
         [&](Structure& s) {
             s.nodes[0].x |= 0x1fffff;
             s.nodes[0].y |= 0x1fffff;
         }},
        {"a corner moved", [&](Structure& s) { s.triangles[4].y ^= 1; }},
        {"a triangle of another id", [&](Structure& s) { s.triangles[3].w = s.triangles[0].w; }},
        {"bounds too small", [&](Structure& s) { s.header.hi.x *= 0.99f; }},
        {"an origin of its own", [&](Structure& s) { s.header.gridOrigin.y += 0.01f; }},
        {"a node too many",
         [&](Structure& s) {
             s.nodes.push_back(s.nodes.back());
             ++s.header.nodeCount;
         }},
        {"a node too few",
         [&](Structure& s) {
             s.nodes.pop_back();
             --s.header.nodeCount;
         }},
    };
    for (const auto& [name, plant] : faults) {
        Structure bad = good;
        plant(bad);
        EXPECT_NE(bsp::findFault(bad, triangles), std::nullopt) << name;
    }
}

}  // namespace
}  // namespace raig

// Hard case 62: links that lead around, forged in a structure that was sound when it was built. Tracers must say so and not
// hang, on the CPU and on devices, whatever is asked.
#include "rays/cpu_walk.hpp"
#include "rays/tracer.hpp"
#include "structures/bvh_trail.hpp"
#include "support/devices.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using test::Variant;

constexpr uint32_t leaf = 0x80000000u;  // of a link, or of a list's last word

/// Every node is a child of its own.
void forgeTrail(Structure& structure) {
    for (uint32_t node = 0; node < structure.header.nodeCount; ++node)
        for (uint32_t slot = 0; slot < bvh::trailArity(structure.header); ++slot) {
            uint32_t& word = bvh::trailWord(structure, node, slot);
            if (word < leaf) word = node;
        }
}

/// Every node that a ray misses leads to itself.
void forgeBvh(Structure& structure) {
    if (bvh::isTrail(structure.header)) return forgeTrail(structure);
    const uint32_t walk = structure.header.walk;
    const uint32_t wide = walk == shared::WALK_OCTANTS16                            ? 1
                          : walk == shared::WALK_OBBS || walk == shared::WALK_KDOPS ? 4
                                                                                    : 2;
    const uint32_t copy = structure.header.nodeCount + (walk == shared::WALK_SKIP ? 0 : shared::BVH_END_NODES);
    for (uint32_t at = 0; at * wide < structure.nodes.size(); ++at) {
        const uint32_t here = walk == shared::WALK_SKIP ? at : at % copy;
        uint32_t& link = structure.nodes[at * wide].w;
        if (here < structure.header.nodeCount && link < leaf) link = here;
    }
}

void forgeKdTree(Structure& structure) {
    for (uint32_t at = 1; at < structure.nodes[0].x; ++at)
        for (uint32_t* link : {&structure.nodes[at].z, &structure.nodes[at].w})
            if (*link < leaf) *link = 1;
}

void forgeOctree(Structure& structure) {
    for (uint32_t at = 1; at < structure.nodes[0].x; ++at)
        if (structure.nodes[at].x < leaf) structure.nodes[at].x = 1;
}

void forgeBsp(Structure& structure) {
    for (uvec4& node : structure.nodes)
        if (node.w < leaf) node.w &= ~0x1fffffffu;  // the first child is the root
}

/// Lists have no end. Grids have no links: what leads from cell to cell is arithmetic.
void forgeGrid(Structure& structure) {
    for (size_t at = structure.nodes[1].x; at < structure.nodes.size(); ++at) structure.nodes[at] &= ~leaf;
}

/// True if there is something to forge.
bool forge(Structure& structure) {
    if (structure.name == "bvh")
        forgeBvh(structure);
    else if (structure.name == "kdtree")
        forgeKdTree(structure);
    else if (structure.name == "octree")
        forgeOctree(structure);
    else if (structure.name == "bsp")
        forgeBsp(structure);
    else if (structure.name == "grid")
        forgeGrid(structure);
    else
        return false;
    return true;
}

class Corrupt : public testing::Test {
protected:
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 4, /* count= */ 300);
    std::vector<Hit> hits = std::vector<Hit>(300);
};

TEST_F(Corrupt, LinksAreNoticedOnTheCpu) {
    size_t forged = 0;
    for (const Variant& variant : test::walkVariants()) {
        Structure structure = variant.build(triangles);
        if (!forge(structure)) continue;
        ++forged;
        const auto tracer = makeCpuTracer(structure);
        EXPECT_NE(structureType(variant.structure).findFault(structure, triangles), std::nullopt) << variant;
        EXPECT_THROW(tracer->trace(rays, hits, Query::closest), CorruptStructure) << variant;
        // Whatever is hit first may end the walk before it goes around: but it ends.
        const std::vector<Ray> misses(rays.size(), {vec3(3, 0.1f, 0.2f), 0.0f, vec3(-1, 0, 0), 1e-3f});
        try {
            tracer->trace(misses, hits, Query::any);
        } catch (const CorruptStructure& error) {
            EXPECT_NE(std::string(error.what()).find(variant.structure + " structure is corrupt"), std::string::npos);
        }
    }
    EXPECT_GE(forged, 10u);
}

class CorruptOnDevices : public OnEveryDevice {};

TEST_P(CorruptOnDevices, LinksAreNoticed) {
    Device device(info);
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 4, /* count= */ 100);
    std::vector<Hit> hits(rays.size());
    for (const StructureType& type : structureTypes()) {
        Structure structure = type.build(triangles, {});
        if (!forge(structure)) continue;
        EXPECT_THROW(makeDeviceTracer(device, structure)->trace(rays, hits, Query::closest), CorruptStructure) << type.name;
    }
}

INSTANTIATE_TEST_SUITE_P(, CorruptOnDevices, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig

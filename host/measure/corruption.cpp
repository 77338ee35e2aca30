#include "measure/corruption.hpp"

#include "structures/bvh_trail.hpp"

namespace raig {

namespace {

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

}  // namespace

bool leadAround(Structure& structure) {
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

}  // namespace raig

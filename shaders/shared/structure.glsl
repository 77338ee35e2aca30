// What every structure's walk finds in memory besides its nodes and triangles.
#ifndef RAIG_SHARED_STRUCTURE
#define RAIG_SHARED_STRUCTURE

// Coordinates in a structure (corners, boxes, bounds) are those of the scene times `unit`, a power of two that brings the
// largest to [1, 2): exact, and no product of differences comes near the ends of the float range, whatever the scene's size.
struct StructureHeader {
    vec3 lo;              // bounds of all triangles: lo > hi if there are none
    uint nodeCount;       // nodes of one copy of the tree
    vec3 hi;
    uint triangleCount;   // references in the triangle array: three uvec4 each (see TRIANGLE_STRIDE)
    vec3 gridOrigin;      // quantised planes: coordinate = gridOrigin + q * gridStep
    uint walk;            // which of the structure's walks the nodes are laid out for
    vec3 gridStep;
    float unit;
};

// A triangle reference is three uvec4: the corners' bits in .xyz, and in .w the global id, TRIANGLE_* flags, 0.
const uint TRIANGLE_STRIDE = 3u;
const uint TRIANGLE_SEE_THROUGH = 1u;  // lets light through: no obstacle to shadow rays

// Walks of bvh, and how many nodes end each copy of the tree: as many as a walk takes steps before it looks, and one.
const uint WALK_SKIP = 0u;       // one depth-first tree with skip links, nodes of 32 bytes
const uint WALK_OCTANTS = 1u;    // eight, one for each octant of directions, nodes of 32 bytes
const uint BVH_END_NODES = 7u;
const uint WALK_OCTANTS16 = 2u;  // eight, nodes of 16 bytes with 16-bit planes

#endif

// What every structure's walk finds in memory besides its nodes and triangles.
#ifndef RAIG_SHARED_STRUCTURE
#define RAIG_SHARED_STRUCTURE

// Coordinates in a structure (corners, boxes, bounds) are those of the scene times `unit`, a power of two that brings the
// largest to [1, 2): exact, and no product of differences comes near the ends of the float range, whatever the scene's size.
struct StructureHeader {
    vec3 lo;              // bounds of all primitives: lo > hi if there are none
    uint nodeCount;       // nodes of one copy of the tree
    vec3 hi;
    uint triangleCount;   // references in the array of primitives: three uvec4 each (see TRIANGLE_STRIDE)
    vec3 gridOrigin;      // quantised planes: coordinate = gridOrigin + q * gridStep
    uint walk;            // which of the structure's walks the nodes are laid out for
    vec3 gridStep;
    float unit;
};

// A reference to a primitive is three uvec4: a triangle's corners' bits in .xyz, and in .w the global id, TRIANGLE_* flags,
// 0. Those of a sphere are its centre, (radius, 0, 0) and 0.
const uint TRIANGLE_STRIDE = 3u;
const uint TRIANGLE_SEE_THROUGH = 1u;  // lets light through: no obstacle to shadow rays
const uint TRIANGLE_SPHERE = 2u;       // is a sphere

// header.walk is less than this, whatever the structure.
const uint MAX_WALKS = 15u;

// Walks of bvh, by what bounds a node. Those to WALK_KDOPS, but for the first, have eight copies of the tree, one for each
// octant of directions.
const uint WALK_SKIP = 0u;       // one depth-first tree, boxes of floats: 32 bytes a node
const uint WALK_OCTANTS = 1u;    // boxes of floats: 32 bytes
const uint WALK_OCTANTS16 = 2u;  // boxes with 16-bit planes: 16 bytes
const uint WALK_SPHERES = 3u;    // spheres: 32 bytes
const uint WALK_OBBS = 4u;       // oriented boxes: 64 bytes
const uint WALK_KDOPS = 5u;      // seven slabs, the axes' and the diagonals': 64 bytes
// One tree, whose nodes hold the boxes of all their children: WALK_TRAIL, and log2 of how many children, less 1; and 3 for
// planes of 16 bits, or 6 for 8 bits, instead of 32.
const uint WALK_TRAIL = 6u;

// How many nodes end each copy of the tree: as many as a walk takes steps before it looks, and one.
const uint BVH_END_NODES = 7u;

// Walks of kdtree.
const uint WALK_RESTART = 0u;      // no stack
const uint WALK_SHORT_STACK = 1u;  // one of two entries

// The walk of grid where parts have parts. Others are the number of levels less one.
const uint WALK_NESTED_GRID = 2u;

// Two levels: meshes that stand in several places have one structure each, a bottom, in their own space. All bottoms are of
// one kind and walk. The header is the whole scene's: its nodeCount that of one copy of the top tree, its triangleCount that
// of all references. The array of nodes begins with, one after the other:
//   the top tree   depth first, with skip links, over the boxes of instances, in the scene's unit; two uvec4 a node: lower
//                  corner, word; upper corner, 0. The word is the skip link, or TOP_LEAF | an instance. One copy for each
//                  octant of directions, or one for all: gridStep.x is how many nodes the copies are apart (0: there is
//                  one).
//   instances      INSTANCE_STRIDE uvec4 each, see below; the first lies at INSTANCES_UNIT times gridStep.y
//   bottoms        BOTTOM_STRIDE uvec4 each: a StructureHeader, and where its nodes and its references begin, in uvec4
// and then the bottoms' nodes.
const uint TOP_LEAF = 0x80000000u;
const uint BOTTOM_STRIDE = 5u;
const uint INSTANCES_UNIT = 64u;  // so that a float holds where instances begin

// An instance, all bits of floats but for the words: the Placement of the bottom's unit in the scene's; three rows of its
// inverse's linear part, and in .w a point in the bottom's space; where that point is in the scene, and the first id; then a
// word: where its bottom lies, in uvec4; a word: INSTANCE_* flags; and two numbers for the slack
// (host/structures/instance_record.cpp).
const uint INSTANCE_STRIDE = 8u;
const uint INSTANCE_MIRRORS = 1u;  // corners 1 and 2 change places

#endif

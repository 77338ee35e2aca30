// The walk of bvh over nodes that hold the boxes of up to two children.
#define TRAIL_ARITY 2u
#include "structures/trail.glsl"

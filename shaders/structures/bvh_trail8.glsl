// The walk of bvh over nodes that hold the boxes of up to eight children.
#define TRAIL_ARITY 8u
#include "structures/trail.glsl"

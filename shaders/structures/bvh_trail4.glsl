// The walk of bvh over nodes that hold the boxes of up to four children.
#define TRAIL_ARITY 4u
#include "structures/trail.glsl"

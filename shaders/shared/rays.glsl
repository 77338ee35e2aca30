// Rays and hits, as they lie in memory on both sides of the border.
#ifndef RAIG_SHARED_RAYS
#define RAIG_SHARED_RAYS

// No primitive: the ray hits nothing.
const uint NO_HIT = 0xffffffffu;

// origin + t * direction for t in [tMin, tMax]. The direction need not be unit length. A ray with a NaN or infinite
// component, no direction, or tMin > tMax hits nothing.
struct Ray {
    vec3 origin;
    float tMin;
    vec3 direction;
    float tMax;
};

// The point (1 - u - v) a + u b + v c of triangle `primitive` (its global id) with corners a, b, c, at distance t. Of a
// sphere: its point at distance t; u and v are 0.
struct Hit {
    float t;
    float u;
    float v;
    uint primitive;
};

#endif

// An item buffer: for each pixel, which reference of a structure a raster found nearest there.
#ifndef RAIG_SHARED_ITEMS
#define RAIG_SHARED_ITEMS

// An item, and so a hint, is two words: a reference, of two levels counted from its bottom's first; and an instance, 0 if
// there is one level. Or one of these instead of a reference:
const uint NO_ITEM = 0xffffffffu;  // nothing was found there
const uint NO_HINT = 0xfffffffeu;  // not known, nor asked for

// A ray may meet what its own place in the picture shows, or one of the three places nearest to that.
const uint HINTS_A_RAY = 4u;

// How points, in the structure's unit and relative to the eye, become those of clip space: (dot(x, (p, 1)), dot(y, ...),
// ...).
struct ItemView {
    vec4 x;
    vec4 y;
    vec4 z;
    vec4 w;
    vec3 eye;
    uint instancesAt;  // where in the nodes instances begin, if there are two levels
};

// What one call draws.
struct ItemCall {
    uint first;         // reference, counted as in items
    uint referencesAt;  // where those of the bottom begin, in uvec4
    uint listAt;        // where in the list of instances those of the call begin
    uint unused;
};

// Before the items, which are rows of partWidth * scale from the part's left: which rows there are.
struct ItemWindow {
    uint firstRow;  // in pixels of the part
    uint rows;
    uint scale;     // items a pixel, each way
    uint unused;
};

#endif

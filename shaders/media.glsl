// Which media a ray is in, where glass holds water and water air.
//
// A medium is what closed surfaces hold that have one refraction index and one absorption. Media have numbers from 1 on;
// air, which is around them all, and what open surfaces seem to hold, have none. A ray carries the numbers of up to four
// media that it is in, a byte each, the one that it entered last lowest, and it is that one that it runs through. So what
// lies within another takes its place. Where two overlap a ray runs through the one that it has entered later, and nothing
// is seen of where it leaves the other. If a fifth is entered the outermost is forgotten. A surface that is not closed
// parts what is around it from what it seems to hold, and nothing is remembered of it.
//
// Source: Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images", with the order of entering for their
// priorities, which scene files do not have.
//
// Whoever includes this declares `frame`, scene_at(i) and FEATURES before it, and includes surface.glsl.

// What a ray meets in a surface, as far as media go.
struct Crossing {
    float from;       // refraction indices: of where the ray is ...
    float to;         // ... and of what is beyond
    uint within;      // the media that the ray is in: of reflected rays
    uint beyond;      // those of transmitted rays
    vec3 absorption;  // of where the ray is
    bool absorbs;
    bool hidden;      // on both sides is the same, that was entered later: the ray goes on as if nothing were there
    bool forgets;     // there are more media than are remembered
};

uint entered(uint media, uint medium) { return medium == 0u ? media : media << 8u | medium; }

// `media` without the one of that number that was entered last; all of them if none is.
uint leftBehind(uint media, uint medium) {
    uint at = media >> 24u == medium ? 3u : 4u;
    at = (media >> 16u & 255u) == medium ? 2u : at;
    at = (media >> 8u & 255u) == medium ? 1u : at;
    at = (media & 255u) == medium ? 0u : at;
    uint inner = (1u << (8u * min(at, 3u))) - 1u;
    return at == 4u ? media : (media & inner) | (media >> 8u & ~inner);
}

// The absorption of medium `medium`, or of air for 0, and its refraction index.
vec4 mediumOf(uint medium) { return rowOf(scene_at(frame.mediaAt + medium)); }

// Surfaces that are thin, or let no light through, part nothing.
Crossing crossingAt(SurfacePoint p, uint media) {
    bool parts = p.transmissive && !p.thin;
    bool leaves = parts && !p.front;
    float inside = leaves ? p.ior : 1.0f;
    float outside = leaves ? 1.0f : p.ior;
    if ((FEATURES & FEATURE_NESTED) == 0u)
        return Crossing(inside, outside, 0u, 0u, p.absorption, leaves, false, false);

    uint rest = leftBehind(media, p.medium);
    bool known = rest != media;
    // What is left without having been entered was entered unseen: by an eye on its surface, or where surfaces touch.
    uint within = leaves && !known ? entered(media, p.medium) : media;
    uint beyond = media;
    if (parts) beyond = leaves ? rest : entered(media, p.medium);
    vec4 here = mediumOf(within & 255u);
    vec4 there = mediumOf(beyond & 255u);
    bool open = p.medium == 0u;
    float from = parts ? (leaves && open ? p.ior : here.w) : inside;
    float to = parts ? (!leaves && open ? p.ior : there.w) : outside;
    vec3 absorption = leaves && open ? p.absorption : vec3(here.x, here.y, here.z);
    bool hidden = leaves && known && (media & 255u) != p.medium;
    bool forgets = parts && !leaves && !open && media >> 24u != 0u;
    return Crossing(from, to, within, beyond, absorption, largestOf(absorption) > 0.0f, hidden, forgets);
}

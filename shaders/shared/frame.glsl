// A picture in the making, as it lies in memory on both sides of the border.
//
// A frame is rendered in tiles. Each pixel of a tile has a slot, which follows one ray at a time: first the camera ray of
// each sample, then, depth first, the reflected and transmitted rays below it; or, one after the other, those of a path.
#ifndef RAIG_SHARED_FRAME
#define RAIG_SHARED_FRAME

// What all rays of a frame have in common.
struct FrameParams {
    vec3 eye;
    float halfWidth;         // of the picture, in the plane at distance 1 (perspective) or in scene units (orthographic)
    vec3 forward;
    float halfHeight;
    vec3 right;
    uint orthographic;       // 1 or 0
    vec3 up;
    float minContribution;   // MIN_CONTRIB: a ray of less weight is not followed; but see roulette
    vec3 zenith;
    uint width;              // of the picture, in pixels
    vec3 horizon;
    uint height;
    vec3 ground;
    uint samples;            // a pixel
    vec3 ambient;
    uint seed;
    uint maxDepth;           // NIVELL_MAX: a ray of greater depth is not followed
    uint slots;              // that there is memory for: the distance between entries of a slot
    uint lightCount;         // point, spot and directional lights
    uint emitterCount;       // triangles that emit light
    uint shadowRays;         // of one shading point: one a light, the emitters, the environment, as far as there are any
    uint materialsAt;        // where in the scene's data these begin, in elements
    uint lightsAt;
    uint emittersAt;
    uint trianglesAt;
    uint verticesAt;
    uint vertexStride;       // elements a vertex
    uint texturesAt;
    uint decodeAt;           // 256 floats: what an sRGB byte means
    uint spheresAt;
    uint instancesAt;        // if there are instances
    uint instanceCount;
    uint left;               // of the part of the picture that is rendered: in pixels, from the picture's left ...
    uint top;                // ... and from its top
    uint partWidth;
    uint partHeight;
    float lensRadius;        // in scene units
    float lensSlope;         // the lens's radius over the distance at which the picture is sharp
    uint mediaAt;            // air, then the media, by number
    uint eyeMedia;           // those that the eye is in: see shaders/media.glsl
    uint environmentAt;      // if there is one
    uint environmentSide;    // texels
    float reach;             // how far ambient occlusion looks
    float roulette;          // a ray of a path that weighs less goes on by chance
    float emitterScale;      // emitters are picked at a point, by area, with its emission's luminance times this: see p.glow
    uint unused0;
    uint unused1;
    uint unused2;
};

// One dispatch over a list of slots.
struct TileStep {
    uint count;       // entries of the list
    uint listAt;      // slotList[listAt + i], i < count: a slot at work, or NO_SLOT
    uint nextAt;      // where the list of the next step begins
    uint compacts;    // 1: only slots that go on enter that list, in any order; 0: all stay in their places
    uint firstPixel;  // of the tile, in the order of pixelOf()
};

// Surfaces that a ray may pass straight through by their alpha, one after the other.
CONSTANT uint MOST_PASSES = 64u;

// The width a of a lobe (shaders/lobe.glsl) is at least this for lights without size, whose images in smooth surfaces no
// samples would find otherwise, and for emitters and the environment, which are asked at one point at random: what is left
// of their image beside the reflected ray's is blurred so far.
CONSTANT float LEAST_SPREAD = 0.01f;
CONSTANT float LEAST_SAMPLED_SPREAD = 0.0625f;

// To paths, surfaces of a smaller one are mirrors, and others have no mirror besides.
CONSTANT float LEAST_DRAWN_SPREAD = 0.001f;

// In the place of a slot that has finished.
CONSTANT uint NO_SLOT = 0xffffffffu;

// Where a slot stands: its current ray, and what its pixel has come to.
struct PathState {
    vec3 weight;         // what the ray's radiance counts in the pixel
    uint depth;          // reflections and refractions since the camera
    vec3 sum;            // radiance of all samples so far
    float discarded;     // greatest components of the weights of the rays that were not followed, summed
    uint pixel;          // y * width + x
    uint sampleIndex;
    uint key;            // the ray's place in the tree of rays: 0, children 2k + 1 and 2k + 2; in a path, 0, 1, 2 ...
    uint pendingCount;   // rays of this sample yet to be followed
    uint shadowRays;     // asked for so far, in all samples
    uint deepest;        // depth reached, in all samples
    uint media;          // what the ray is in: see shaders/media.glsl
    uint forgotten;      // how often more was entered than that holds, in all samples
    float travelled;     // by light from the ray's origin to the camera
    uint passes;         // surfaces that the ray has passed straight on, since the camera
    float density;       // of a path's ray, with which its direction was drawn, by solid angle; 0: it was not
    uint unused;
};

// A ray that waits to be followed.
struct PendingRay {
    vec3 origin;
    uint depth;
    vec3 direction;
    uint key;
    vec3 weight;
    uint media;
    float travelled;
    uint passes;
    float begin;         // distance from the origin that the ray goes on from
    float density;
};

// A pixel that has all its samples, for now.
struct PixelResult {
    vec3 sum;         // radiance of all samples
    float discarded;  // discarded weight of all samples
    uint pixel;
    uint shadowRays;
    uint deepest;
    uint forgotten;
};

// What the ray through a pixel's centre meets first. Where it meets nothing depth is infinite, the ids are NO_HIT, all else
// 0.
struct PrimaryHit {
    vec3 position;   // in the world
    float depth;     // along the ray, whose direction is unit length
    vec3 normal;     // unit; interpolated where shading interpolates, on the ray's side
    float u;         // texture coordinates if there are any in the scene, else the hit's barycentric ones
    vec3 albedo;     // linear
    float v;
    uint primitive;  // the global id
    uint instance;   // for the host to fill in
    uint material;
    uint pixel;
};

// Points of emitters that are drawn for one shadow ray: four at most.
CONSTANT uint EMITTER_CANDIDATES = 4u;

// The end of rays that have none: farther than any two points that rays can meet are apart.
CONSTANT float FAR_AWAY = 3.4e38f;

// What the scene's data holds, so that code for what it lacks can be left out.
CONSTANT uint FEATURE_NORMALS = 1u;
CONSTANT uint FEATURE_UVS = 2u;
CONSTANT uint FEATURE_COLORS = 4u;
CONSTANT uint FEATURE_TEXTURES = 8u;
CONSTANT uint FEATURE_MIRRORS = 16u;       // surfaces that reflect
CONSTANT uint FEATURE_TRANSMISSION = 32u;  // surfaces that let light through
CONSTANT uint FEATURE_LIGHTS = 64u;
CONSTANT uint FEATURE_EMITTERS = 128u;
CONSTANT uint FEATURE_SPHERES = 256u;
CONSTANT uint FEATURE_INSTANCES = 512u;    // meshes are stored once, in their own space
CONSTANT uint FEATURE_LENS = 1024u;        // the camera is no pinhole
CONSTANT uint FEATURE_NESTED = 2048u;      // media may lie within each other, or hold other things
CONSTANT uint FEATURE_ENVIRONMENT = 4096u; // there is a picture of what is where nothing is
CONSTANT uint FEATURE_SHINING = 8192u;     // ... which is not black
CONSTANT uint FEATURE_TENT = 16384u;       // pixels are filtered by a tent ...
CONSTANT uint FEATURE_GAUSS = 32768u;      // ... or by Gauss's curve
CONSTANT uint FEATURE_COLOR_TEXTURES = 1u << 16u;      // FEATURE_TEXTURES: any of these five
CONSTANT uint FEATURE_ROUGHNESS_TEXTURES = 1u << 17u;
CONSTANT uint FEATURE_NORMAL_TEXTURES = 1u << 18u;
CONSTANT uint FEATURE_EMISSION_TEXTURES = 1u << 19u;
CONSTANT uint FEATURE_OCCLUSION_TEXTURES = 1u << 20u;
CONSTANT uint FEATURE_TEXTURE_TRANSFORMS = 1u << 21u;
CONSTANT uint FEATURE_MORE_UVS = 1u << 22u;            // a second set, which textures ask for
CONSTANT uint FEATURE_TANGENTS = 1u << 23u;
CONSTANT uint FEATURE_LOBES = 1u << 24u;               // surfaces that mirror what no reflected ray brings
CONSTANT uint FEATURE_COVERAGE = 1u << 25u;            // surfaces that let rays pass by their alpha ...
CONSTANT uint FEATURE_BLENDS = 1u << 26u;              // ... and some of them in part

// What the picture asks for besides: an integrator that is not Whitted's.
CONSTANT uint FEATURE_PATH = 1u << 29u;
CONSTANT uint FEATURE_AO = 1u << 30u;

// The scene's data is an array of uvec4. A triangle is one element: its vertices and its material; and so is a sphere in its
// place: where it is among the spheres, NO_VERTEX, NO_VERTEX, material. A sphere is one element: centre, radius. A vertex is
// `vertexStride`: position and u; normal and v if there are normals or uvs; tangent if there are tangents; the second set's
// u and v, 0, 0 if there is one; colour if there are colours. If there are instances, spheres are in the world all the same,
// each instance's. An instance is FRAME_INSTANCE_STRIDE: Placement, then NormalPlacement with first id | where its mesh's
// triangles begin, less the first id (modulo 2^32) | its first sphere << 1, and 1 if corners 1 and 2 change places. An
// emitter is one element: cumulated probability, triangle, area, 0. A texture is TEXTURE_STRIDE, all places counted from
// texturesAt: where its levels begin, how many there are, wraps | set << 4, texels that a unit of its set's coordinates has,
// by area | u of its transform | v. A level is one element: where its texels begin, width, height, 0. Texels are four an
// element. Media: one element each (absorption, refraction index), air first. An environment: an element a texel (radiance,
// share as far as it in its row), row by row, then the rows' shares, four an element.
//
// A material is MATERIAL_STRIDE: base colour, metallic | emission, roughness | absorption, ior | transmission, alpha,
// reflectance along the normal by ior, flags | textures of base colour, roughness, normal, emission (or NO_TEXTURE) |
// texture of occlusion, its strength, the normal texture's scale, medium | alpha from which on it is there, 0 if it blends,
// 0, 0, 0.
CONSTANT uint MATERIAL_STRIDE = 7u;
CONSTANT uint TEXTURE_STRIDE = 3u;
CONSTANT uint FRAME_INSTANCE_STRIDE = 6u;
CONSTANT uint LIGHT_STRIDE = 4u;     // position type | direction range | intensity cos(outer) | cos(inner) shadows 0 0

CONSTANT uint SURFACE_THIN = 1u;
CONSTANT uint SURFACE_TRANSMITS = 2u;
CONSTANT uint SURFACE_ALPHA_VARIES = 4u;
CONSTANT uint NO_TEXTURE = 0xffffffffu;
CONSTANT uint NO_VERTEX = 0xffffffffu;

CONSTANT uint LIGHT_POINT = 0u;
CONSTANT uint LIGHT_SPOT = 1u;
CONSTANT uint LIGHT_DIRECTIONAL = 2u;

#endif

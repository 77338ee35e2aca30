// Large read-only arrays of uvec4 on a device: RAIG_ARRAY(name, binding) declares one and a function name_at(i) to read it.
//
// An array is split over up to four bindings of 2^shift elements each, as one binding may be too small (128 MiB on some
// devices); a specialization constant tells how many are in use, so that the usual case, one, costs nothing. Texel buffers
// load faster on some devices and storage buffers on others: RAIG_LOAD_TEXEL chooses.
#ifndef RAIG_SHARED_LOAD
#define RAIG_SHARED_LOAD

const uint MAX_CHUNKS = 4u;

#ifndef __cplusplus
#if RAIG_LOAD_TEXEL
#define RAIG_ARRAY(name, slot) layout(set = 0, binding = slot) uniform usamplerBuffer name##Chunks[MAX_CHUNKS];
#define RAIG_CHUNK(name, chunk, i) texelFetch(name##Chunks[chunk], int(i))
#else
#define RAIG_ARRAY(name, slot) \
    layout(set = 0, binding = slot, std430) readonly buffer name##Block { uvec4 data[]; } name##Chunks[MAX_CHUNKS];
#define RAIG_CHUNK(name, chunk, i) name##Chunks[chunk].data[i]
#endif

// Defines name_at(i). `chunks` and `shift` are specialization constants; indices are dynamically uniform in none, so every
// chunk is indexed by a constant.
#define RAIG_ARRAY_AT(name, chunks, shift) \
    uvec4 name##_at(uint i) { \
        if (chunks == 1u) return RAIG_CHUNK(name, 0, i); \
        uint chunk = i >> shift; \
        uint rest = i & ((1u << shift) - 1u); \
        if (chunk == 0u) return RAIG_CHUNK(name, 0, rest); \
        if (chunk == 1u) return RAIG_CHUNK(name, 1, rest); \
        if (chunk == 2u) return RAIG_CHUNK(name, 2, rest); \
        return RAIG_CHUNK(name, 3, rest); \
    }
#endif

#endif

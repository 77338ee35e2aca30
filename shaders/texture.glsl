// Look-ups of images in the scene's data, filtered by how much of them a ray covers.
//
// Whoever includes this declares `frame`, scene_at(i) and FEATURES before it.
//
// A ray covers a square of `width` of texture coordinates (texture_mapping.glsl), which is x texels of the image. Each level
// of its pyramid has half the texels of the one before, a side: what is looked up is bilinear in level e = floor(log2 x) and
// in the next, and between them linear in x: continuous everywhere, and made of additions and multiplications only.
// Magnified images (x <= 1) are bilinear, and what lies beyond the last level, of one texel, is that texel.
// Source: Williams 1983, "Pyramidal Parametrics" (levels, and between them); Akenine-Moeller et al. 2019, "Texture
// Level-of-Detail Strategies for Real-Time Ray Tracing" (the square that a ray covers).

// What sRGB byte `value` means in linear light.
float decodeByte(uint value) {
    uvec4 four = scene_at(frame.decodeAt + value / 4u);
    uint lane = value % 4u;
    uint bits = lane < 2u ? (lane == 0u ? four.x : four.y) : (lane == 2u ? four.z : four.w);
    return uintBitsToFloat(bits);
}

// A texel, its first three bytes sRGB if `encoded`; alpha never is.
vec4 texelAt(uint firstElement, uint index, bool encoded) {
    uvec4 four = scene_at(firstElement + index / 4u);
    uint lane = index % 4u;
    uint texel = lane < 2u ? (lane == 0u ? four.x : four.y) : (lane == 2u ? four.z : four.w);
    uvec4 bytes = uvec4(texel & 255u, (texel >> 8u) & 255u, (texel >> 16u) & 255u, texel >> 24u);
    precise vec4 linear_ = vec4(float(bytes.x), float(bytes.y), float(bytes.z), float(bytes.w)) * (1.0f / 255.0f);
    return encoded ? vec4(decodeByte(bytes.x), decodeByte(bytes.y), decodeByte(bytes.z), linear_.w) : linear_;
}

// Where texture coordinate u falls among the texels of one period, in texel widths from the first one's centre. The period
// is brought to [0, 1] before it is scaled, so that no coordinate, however large, leaves the range of integers.
float texelPosition(float u, uint size, uint wrap) {
    precise float repeated = u - floor(u);
    precise float mirrored = 2.0f * (0.5f * u - floor(0.5f * u));
    float inPeriod = wrap == 0u ? repeated : (wrap == 1u ? clamp(u, 0.0f, 1.0f) : mirrored);
    precise float position = inPeriod * float(size) - 0.5f;
    return position;
}

// The texel that stands at position `i` >= -1 of one period (0: repeat, 1: clamp, 2: mirror).
uint texelIndex(int i, int size, uint wrap) {
    int repeated = i < 0 ? i + size : (i >= size ? i - size : i);
    int mirrored = i >= size ? 2 * size - 1 - i : i;
    int index = wrap == 0u ? repeated : (wrap == 1u ? i : mirrored);
    return uint(clamp(index, 0, size - 1));
}

// Between the four texels about uv, of a level that is described by `level`: where its texels begin, width, height.
vec4 bilinear(uvec4 level, uint wraps, vec2 uv, bool encoded) {
    uint wrapU = wraps & 3u;
    uint wrapV = (wraps >> 2u) & 3u;
    float x = texelPosition(uv.x, level.y, wrapU);
    float y = texelPosition(uv.y, level.z, wrapV);
    int x0 = int(floor(x));
    int y0 = int(floor(y));
    precise float fx = x - floor(x);
    precise float fy = y - floor(y);
    uint left = texelIndex(x0, int(level.y), wrapU);
    uint right = texelIndex(x0 + 1, int(level.y), wrapU);
    uint top = texelIndex(y0, int(level.z), wrapV) * level.y;
    uint bottom = texelIndex(y0 + 1, int(level.z), wrapV) * level.y;
    uint texels = frame.texturesAt + level.x;
    precise vec4 above =
        (1.0f - fx) * texelAt(texels, top + left, encoded) + fx * texelAt(texels, top + right, encoded);
    precise vec4 below =
        (1.0f - fx) * texelAt(texels, bottom + left, encoded) + fx * texelAt(texels, bottom + right, encoded);
    precise vec4 value = (1.0f - fy) * above + fy * below;
    return value;
}

// Which set of texture coordinates texture `texture_` asks for: 0 or 1.
uint textureSet(uint texture_) { return (scene_at(frame.texturesAt + texture_ * TEXTURE_STRIDE).z >> 4u) & 1u; }

// Where uv, of its set, falls in texture `texture_`: its transform, in full for positions (last = 1) or without its offset
// for differences (last = 0).
vec2 transformed(uint texture_, vec2 uv, float last) {
    if ((FEATURES & FEATURE_TEXTURE_TRANSFORMS) == 0u) return uv;
    uvec4 u = scene_at(frame.texturesAt + texture_ * TEXTURE_STRIDE + 1u);
    uvec4 v = scene_at(frame.texturesAt + texture_ * TEXTURE_STRIDE + 2u);
    precise vec2 result = vec2(
        uintBitsToFloat(u.x) * uv.x + uintBitsToFloat(u.y) * uv.y + uintBitsToFloat(u.z) * last,
        uintBitsToFloat(v.x) * uv.x + uintBitsToFloat(v.y) * uv.y + uintBitsToFloat(v.z) * last);
    return result;
}

// The mean of texture `texture_` over a square of `width` about uv, of its set, (0, 0) being the top left corner; its first
// three channels decoded from sRGB if `encoded`.
vec4 textureAt(uint texture_, vec2 uv, float width, bool encoded) {
    uvec4 about = scene_at(frame.texturesAt + texture_ * TEXTURE_STRIDE);
    precise float x = width * uintBitsToFloat(about.w);
    uint bits = floatBitsToUint(x);
    bool minified = x > 1.0f;  // false for NaN
    uint exponent = minified ? (bits >> 23u) - 127u : 0u;
    precise float share = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u) - 1.0f;
    uint last = about.y - 1u;
    uint fine = min(exponent, last);
    uint coarse = min(exponent + 1u, last);
    vec2 place = transformed(texture_, uv, 1.0f);
    uint levels = frame.texturesAt + about.x;
    vec4 finer = bilinear(scene_at(levels + fine), about.z, place, encoded);
    if (!minified) return finer;
    vec4 coarser = bilinear(scene_at(levels + coarse), about.z, place, encoded);
    precise vec4 value = (1.0f - share) * finer + share * coarser;
    return value;
}

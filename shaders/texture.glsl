// Bilinear look-ups of sRGB images in the scene's data.
//
// Whoever includes this declares `frame` and scene_at(i) before it.

// What sRGB byte `value` means in linear light.
float decodeByte(uint value) {
    uvec4 four = scene_at(frame.decodeAt + value / 4u);
    uint lane = value % 4u;
    uint bits = lane < 2u ? (lane == 0u ? four.x : four.y) : (lane == 2u ? four.z : four.w);
    return uintBitsToFloat(bits);
}

vec3 texelColour(uint firstElement, uint index) {
    uvec4 four = scene_at(firstElement + index / 4u);
    uint lane = index % 4u;
    uint texel = lane < 2u ? (lane == 0u ? four.x : four.y) : (lane == 2u ? four.z : four.w);
    return vec3(decodeByte(texel & 255u), decodeByte((texel >> 8u) & 255u), decodeByte((texel >> 16u) & 255u));
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

// The linear colour of texture `texture_` at (u, v), (0, 0) being the top left corner. Alpha is ignored.
vec3 textureColour(uint texture_, float u, float v) {
    uvec4 about = scene_at(frame.texturesAt + texture_);
    uint wrapU = about.w & 3u;
    uint wrapV = (about.w >> 2u) & 3u;
    float x = texelPosition(u, about.y, wrapU);
    float y = texelPosition(v, about.z, wrapV);
    int x0 = int(floor(x));
    int y0 = int(floor(y));
    float fx = x - floor(x);
    float fy = y - floor(y);
    uint left = texelIndex(x0, int(about.y), wrapU);
    uint right = texelIndex(x0 + 1, int(about.y), wrapU);
    uint top = texelIndex(y0, int(about.z), wrapV) * about.y;
    uint bottom = texelIndex(y0 + 1, int(about.z), wrapV) * about.y;
    uint texels = frame.texturesAt + about.x;
    precise vec3 above = (1.0f - fx) * texelColour(texels, top + left) + fx * texelColour(texels, top + right);
    precise vec3 below = (1.0f - fx) * texelColour(texels, bottom + left) + fx * texelColour(texels, bottom + right);
    precise vec3 colour = (1.0f - fy) * above + fy * below;
    return colour;
}

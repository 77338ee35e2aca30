// The camera: which pixel comes when, and the ray through it.
//
// Whoever includes this declares `frame` before it, and includes sampling.glsl and spawn.glsl.

// The pixel (y * width + x in the whole picture) that comes `order`-th of the part that is rendered: strips of 8 rows, in
// blocks of 8 x 8, so that neighbours in time are neighbours in the picture, whatever its size.
// Requires order < partWidth * partHeight.
uint pixelOf(uint order) {
    uint strip = order / (8u * frame.partWidth);
    uint stripHeight = min(8u, frame.partHeight - 8u * strip);
    uint inStrip = order - strip * 8u * frame.partWidth;
    uint block = inStrip / (8u * stripHeight);
    uint blockWidth = min(8u, frame.partWidth - 8u * block);
    uint inBlock = inStrip - block * 8u * stripHeight;
    uint x = 8u * block + inBlock % blockWidth;
    uint y = 8u * strip + inBlock / blockWidth;
    return (frame.top + y) * frame.width + frame.left + x;
}

// A ray that meets nothing, and is found to at once.
Ray noRay() { return Ray(vec3(0.0f), 1.0f, vec3(0.0f), 0.0f); }

// The ray of sample `sampleIndex` of `pixel`: through the pixel's centre if there is one sample, else through a point of the
// pixel stratified over its samples. Row 0 is at the top. The direction is unit length.
Ray cameraRay(uint pixel, uint sampleIndex) {
    vec2 within = vec2(0.5f, 0.5f);
    if (frame.samples > 1u) within = sampleSquare(pixel, sampleIndex, 0u, frame.seed);
    precise float x = 2.0f * (float(pixel % frame.width) + within.x) / float(frame.width) - 1.0f;
    precise float y = 1.0f - 2.0f * (float(pixel / frame.width) + within.y) / float(frame.height);
    precise vec3 right = x * frame.halfWidth * frame.right;
    precise vec3 up = y * frame.halfHeight * frame.up;
    precise vec3 shifted = frame.eye + right + up;
    precise vec3 tilted = frame.forward + right + up;
    if (frame.orthographic != 0u) return Ray(shifted, 0.0f, frame.forward, FAR_AWAY);
    return Ray(frame.eye, 0.0f, unit(tilted), FAR_AWAY);
}

// Radiance from where nothing is, in unit direction d: from the horizon to the zenith (+y) or to the ground, by height.
vec3 skyRadiance(vec3 d) {
    vec3 end = d.y >= 0.0f ? frame.zenith : frame.ground;
    float share = abs(d.y);
    precise vec3 radiance = (1.0f - share) * frame.horizon + share * end;
    return radiance;
}

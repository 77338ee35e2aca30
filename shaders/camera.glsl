// The camera: which pixel comes when, and the ray through it.
//
// Whoever includes this declares `frame` and FEATURES before it, and includes sampling.glsl and spawn.glsl.

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

// Where a sample is taken, from the pixel's middle, in pixels, along one axis: as likely at a place as the pixel's filter
// has weight there, so that the mean of samples is the filtered picture, and a pixel needs nobody else's samples. For x in
// [0, 1). Source: Ernst, Stamminger and Greiner 2006, "Filter Importance Sampling".

// The triangle from -1 over 0 to 1.
float tentPlace(float x) {
    precise float left = sqrt(2.0f * x) - 1.0f;
    precise float right = 1.0f - sqrt(2.0f - 2.0f * x);
    return x < 0.5f ? left : right;
}

// Gauss's curve of standard deviation 1/2, cut off where 0.02425 of it are left on either side, which is at 0.9865. Its
// inverse there, over q, is a polynomial of s = q^2 / (0.32 - q^2), fitted at Chebyshev's points, whose terms hardly cancel:
// places are within 3e-7 pixels of the curve's own.
float gaussPlace(float x) {
    precise float q = 0.9515f * (x - 0.5f);
    precise float s = q * q;
    s = s / (0.32f - s);
    precise float high = -0.0123550327f + s * (0.00384740383f + s * (-0.000729289143f + s * 6.47295868e-5f));
    precise float middle = 0.0833832836f + s * (-0.0496519876f + s * (0.028170898f + s * high));
    precise float place = q * (1.25331444f + s * (0.419964503f + s * (-0.124069487f + s * middle)));
    return place;
}

// A point around the pixel whose corner is (0, 0), for one of the unit square.
vec2 filtered(vec2 square) {
    if ((FEATURES & FEATURE_TENT) != 0u) return vec2(0.5f + tentPlace(square.x), 0.5f + tentPlace(square.y));
    if ((FEATURES & FEATURE_GAUSS) != 0u) return vec2(0.5f + gaussPlace(square.x), 0.5f + gaussPlace(square.y));
    return square;
}

// A ray that meets nothing, and is found to at once.
Ray noRay() { return Ray(vec3(0.0f), 1.0f, vec3(0.0f), 0.0f); }

// The unit disk's point for one of the unit square: squares around the middle become circles, and equal areas equal areas
// [Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square"]. Sine and cosine, of at most an eighth of a turn,
// are the first terms of their series, less than 2^-25 off, as devices' own differ.
vec2 diskOf(vec2 square) {
    precise float a = 2.0f * square.x - 1.0f;
    precise float b = 2.0f * square.y - 1.0f;
    bool wide = abs(a) > abs(b);
    float radius = wide ? a : b;
    precise float turn = (wide ? b : a) / (radius == 0.0f ? 1.0f : radius);  // in eighths, from the axis of `radius`
    precise float s = turn * turn;
    precise float sine =
        turn * (0.785398163f + s * (-0.0807455122f + s * (0.00249039457f + s * (-3.65762042e-5f + s * 3.13361689e-7f))));
    precise float cosine = s * (0.0158543442f + s * (-3.25991887e-4f + s * (3.59086045e-6f + s * -2.46113695e-8f)));
    cosine = 1.0f + s * (-0.308425138f + cosine);
    precise float along = radius * cosine;
    precise float across = radius * sine;
    return wide ? vec2(along, across) : vec2(across, along);
}

// Bends the pinhole's ray, from `origin` along `towards` (whose part along the camera's axis is 1): it starts at a point of
// the lens and meets the pinhole's where that is in focus. Dimension 3 is the lens's; emitters have those that are 1 or 2
// modulo 3. Source: Cook, Porter and Carpenter 1984, "Distributed Ray Tracing".
Ray throughLens(vec3 origin, vec3 towards, uint pixel, uint sampleIndex) {
    vec2 place = diskOf(sampleSquare(pixel, sampleIndex, 3u, frame.seed));
    precise vec3 aside = place.x * frame.right + place.y * frame.up;
    precise vec3 start = origin + frame.lensRadius * aside;
    precise vec3 direction = towards - frame.lensSlope * aside;
    return Ray(start, 0.0f, unit(direction), FAR_AWAY);
}

// The ray of sample `sampleIndex` of `pixel`: through the pixel's centre if there is one sample, else through a point of the
// pixel, or of what its filter reaches, stratified over its samples. Row 0 is at the top. The direction is unit length.
Ray cameraRay(uint pixel, uint sampleIndex) {
    vec2 within = vec2(0.5f, 0.5f);
    if (frame.samples > 1u) within = filtered(sampleSquare(pixel, sampleIndex, 0u, frame.seed));
    precise float x = 2.0f * (float(pixel % frame.width) + within.x) / float(frame.width) - 1.0f;
    precise float y = 1.0f - 2.0f * (float(pixel / frame.width) + within.y) / float(frame.height);
    precise vec3 right = x * frame.halfWidth * frame.right;
    precise vec3 up = y * frame.halfHeight * frame.up;
    precise vec3 shifted = frame.eye + right + up;
    precise vec3 tilted = frame.forward + right + up;
    if ((FEATURES & FEATURE_LENS) != 0u) {
        bool parallel = frame.orthographic != 0u;
        return throughLens(parallel ? shifted : frame.eye, parallel ? frame.forward : tilted, pixel, sampleIndex);
    }
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

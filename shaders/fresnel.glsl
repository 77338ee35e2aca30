// How a surface splits light into reflected (K_R), transmitted (K_T) and scattered, and where the first two go.
//
// Whoever includes this includes surface.glsl, lobe.glsl and media.glsl before it.

struct Split {
    vec3 reflected;       // weight of the reflected ray
    vec3 transmitted;     // weight of the transmitted ray
    vec3 diffuse;         // reflectance of what is scattered
    vec3 rough;           // of light from everywhere, what is mirrored but not brought by the reflected ray
    Lobe lobe;            // what mirrors that, and all of lights without size
    vec3 reflectedWay;    // unit directions
    vec3 transmittedWay;
};

// The share of unpolarised light that is reflected where refraction index n1 meets n2; all of it beyond the critical angle.
// cosI in (0, 1] is the cosine of the angle of incidence. Source: Fresnel's equations, exact.
float fresnelReflectance(float cosI, float n1, float n2) {
    precise float eta = n1 / n2;
    precise float k = 1.0f - eta * eta * (1.0f - cosI * cosI);
    precise float cosT = sqrt(max(k, 0.0f));
    precise float s = (n1 * cosI - n2 * cosT) / (n1 * cosI + n2 * cosT);
    precise float p = (n1 * cosT - n2 * cosI) / (n1 * cosT + n2 * cosI);
    precise float reflectance = 0.5f * (s * s + p * p);
    return k < 0.0f ? 1.0f : reflectance;
}

// d bent by Snell's law at a surface whose normal n faces it, eta = n1 / n2; (0, 0, 0) if it is totally reflected.
vec3 bent(vec3 d, vec3 n, float eta) {
    precise float cosI = -dot(d, n);
    precise float k = 1.0f - eta * eta * (1.0f - cosI * cosI);
    precise vec3 direction = eta * d + (eta * cosI - sqrt(max(k, 0.0f))) * n;
    return k < 0.0f ? vec3(0.0f) : unit(direction);
}

// Where the shading normal sends light to the wrong side of the triangle, the triangle's own normal decides.
vec3 reflectedDirection(vec3 d, SurfacePoint p) {
    precise vec3 smoothWay = d - 2.0f * dot(d, p.shading) * p.shading;
    precise vec3 flatWay = d - 2.0f * dot(d, p.normal) * p.normal;
    return unit(dot(smoothWay, p.normal) <= 0.0f ? flatWay : smoothWay);
}

// e^-x for x >= 0, the same on all devices: 2^-k e^r with |r| <= ln(2) / 2 by Taylor's series; within 2 ULP, 0 beyond 87.
float decay(float x) {
    precise float k = floor(x * 1.44269504f + 0.5f);
    precise float r = (k * 0.693359375f - x) - k * 2.12194440e-4f;
    precise float series = 1.0f + r * (1.0f + r * (0.5f + r * (0.166666667f + r * (0.0416666667f + r * (0.00833333333f +
                           r * (0.00138888889f + r * 0.000198412698f))))));
    precise float result = series * uintBitsToFloat((127u - uint(min(k, 126.0f))) << 23u);
    return x > 87.0f ? 0.0f : result;
}

// What is left of light after `distance_` within what absorbs it [Beer-Lambert].
vec3 absorbed(vec3 absorption, float distance_) {
    precise vec3 depth = absorption * distance_;
    return vec3(decay(depth.x), decay(depth.y), decay(depth.z));
}

// A surface that lets light through: Fresnel's share is reflected, the rest passes or is scattered.
Split splitByFresnel(vec3 d, float cosI, SurfacePoint p, Crossing crossing) {
    float n1 = crossing.from;
    float n2 = crossing.to;
    precise float eta = n1 / n2;
    float reflectance = n1 == n2 ? 0.0f : fresnelReflectance(cosI, n1, n2);
    vec3 way = d;
    if (!p.thin) {
        way = bent(d, p.shading, eta);
        if (dot(way, p.normal) >= 0.0f) way = bent(d, p.normal, eta);
        bool nowhere = way.x == 0.0f && way.y == 0.0f && way.z == 0.0f;
        if (nowhere) reflectance = 1.0f;
    }
    precise float rest = 1.0f - reflectance;
    Lobe lobe = noLobe();
    if ((FEATURES & FEATURE_LOBES) != 0u && (p.front || p.thin)) lobe = lobeOf(p, 1.0f);
    return Split(vec3(reflectance), rest * p.through, rest * p.diffuse, vec3(0.0f), lobe, reflectedDirection(d, p), way);
}

// How light that comes along a ray of unit direction d is split at p. Ensures reflected + rough + diffuse <= 1 for an opaque
// surface.
// Source: Whitted 1980, "An Improved Illumination Model for Shaded Display"; Schlick 1994, "An Inexpensive BRDF Model for
// Physically-based Rendering" (growth of an opaque surface's reflection towards grazing).
Split splitAt(vec3 d, SurfacePoint p, Crossing crossing) {
    precise float cosI = -dot(d, p.shading);
    vec3 reflected = vec3(0.0f);
    float mirrored = 0.0f;  // by the dielectric, in any way
    if ((FEATURES & FEATURE_MIRRORS) != 0u) {
        precise float c = 1.0f - min(cosI, 1.0f);
        precise float k = c * c * c * c * c;
        precise float ofDielectric = p.gloss * (p.dielectric + (p.grazing - p.dielectric) * k);
        precise vec3 ofMetal = p.gloss * (p.metal + (vec3(1.0f) - p.metal) * k);
        precise vec3 both = (1.0f - p.metallic) * vec3(ofDielectric) + p.metallic * ofMetal;
        reflected = both;
        mirrored = ofDielectric;
    }
    vec3 rough = vec3(0.0f);
    Lobe lobe = noLobe();
    if ((FEATURES & FEATURE_LOBES) != 0u) {
        vec2 albedo = lobeAlbedo(clamp(cosI, 0.0f, 1.0f), p.roughness);
        lobe = lobeOf(p, albedo.x);
        precise float left = 1.0f - p.gloss;
        precise vec3 all = left * (lobe.along * (albedo.x - albedo.y) + lobe.grazing * albedo.y);
        precise float gained = 1.0f + p.dielectric * ((1.0f - albedo.x) / albedo.x);
        precise float both = mirrored + left * gained * (p.dielectric * (albedo.x - albedo.y) + p.grazing * albedo.y);
        rough = all;
        mirrored = both;
    }
    // Only what the dielectric does not mirror gets to its coloured inside; a metal has none.
    precise vec3 diffuse = (1.0f - mirrored) * p.diffuse;
    Split split = Split(reflected, vec3(0.0f), diffuse, rough, lobe, vec3(0.0f), d);
    if (crossing.hidden) {
        split = Split(vec3(0.0f), vec3(1.0f), vec3(0.0f), vec3(0.0f), noLobe(), vec3(0.0f), d);
    } else if (p.transmissive) {
        split = splitByFresnel(d, cosI, p, crossing);
    } else if ((FEATURES & FEATURE_MIRRORS) != 0u) {
        split.reflectedWay = reflectedDirection(d, p);
    }
    return split;
}

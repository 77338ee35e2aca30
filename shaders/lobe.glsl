// Light that surfaces mirror in more than one direction: the lobe of a rough surface, and of what no reflected ray brings.
//
// A surface of roughness r is made of small mirrors, whose normals are spread by a = r^2 [Walter et al. 2007, "Microfacet
// Models for Refraction through Rough Surfaces": GGX], which shade each other [Heitz 2014, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs": height-correlated]. Each reflects by f0 + (f90 - f0) (1 - cos)^5
// [Schlick 1994]. Of all of it the reflected ray brings the share `gloss` = max(0, 1 - 2 r)^2 (of a path: all or nothing),
// and the lobe the rest: in light from everywhere, from emitters and from the environment. Point, spot and directional
// lights have no size, so that no reflected ray finds them: of theirs the lobe brings everything. What it misses as it
// leaves out light that goes from mirror to mirror, it gains by a factor [Turquin 2019, "Practical Multiple Scattering
// Compensation for Microfacet Models"].
//
// Whoever includes this includes shared/frame.glsl (LEAST_SPREAD) and surface.glsl before it.

// What the lobe's mirrors reflect along their normals and at grazing, the gain included.
struct Lobe {
    vec3 along;
    vec3 grazing;
};

Lobe noLobe() { return Lobe(vec3(0.0f), vec3(0.0f)); }

// Of light from everywhere, the share that a lobe of roughness r reflects whose mirrors reflect everything (x), and of it
// what (1 - cos)^5 of each reflects (y). Requires cosine, between the eye's direction and the normal, and r in [0, 1].
// Fitted to both for cosines of 0.03 to 1 and r of 0.1 to 1: off by at most 0.033 and 0.032, 0.016 and 0.012 root mean
// square.
vec2 lobeAlbedo(float cosine, float r) {
    precise float root = sqrt(cosine);
    precise float lost = r * ((1.197116f - 2.842857f * root + 1.264805f * cosine) +
                              r * ((-3.802190f + 12.473374f * root - 7.462394f * cosine) +
                                   r * (2.595462f - 8.787570f * root + 6.086005f * cosine)));
    precise float c = 1.0f - cosine;
    precise float grazing = c * c * c * ((-3.206164f + c * (8.244979f - 3.961959f * c)) +
                                         r * ((9.963692f + c * (-22.844650f + 10.347438f * c)) +
                                              r * (-6.954611f + c * (14.808764f - 6.313605f * c))));
    precise float all = clamp(1.0f - lost, 0.25f, 1.0f);
    return vec2(all, clamp(grazing, 0.0f, all));
}

// The lobe of p's surface, whose mirrors alone would reflect the share `albedo` of light from everywhere: 1 leaves out what
// goes from mirror to mirror. Metal and dielectric each gain what they lose, so that a white furnace stays white.
Lobe lobeOf(SurfacePoint p, float albedo) {
    precise float lost = (1.0f - albedo) / albedo;
    precise float ofDielectric = (1.0f - p.metallic) * (1.0f + p.dielectric * lost);
    precise vec3 ofMetal = p.metallic * (vec3(1.0f) + p.metal * lost);
    precise vec3 along = vec3(ofDielectric * p.dielectric) + ofMetal * p.metal;
    precise vec3 grazing = vec3(ofDielectric * p.grazing) + ofMetal;
    return Lobe(along, grazing);
}

// GGX's density D of the normals of mirrors at h, over solid angle, on a surface of normal n: D (n.h) integrates to 1 over
// the hemisphere. So directions mirrored at h drawn from it, by tan^2 = a^2 u / (1 - u) for u in [0, 1), have a density of D
// (n.h) / (4 v.h). Requires unit n and h.
float facetDensity(vec3 n, vec3 h, float a) {
    vec3 across = crossOf(n, h);
    precise float nh = dot(n, h);
    precise float a2 = a * a;
    // 1 - (n.h)^2 as the square of a cross product, which does not cancel where n and h are nearly one.
    precise float spread = dot(across, across) + a2 * (nh * nh);
    precise float density = a2 / (spread * spread) * 0.318309886f;
    return density;
}

// What of light from direction l goes to v, per unit of irradiance (the cosine at the surface is in that): the lobe's BRDF.
// Requires unit n, v and l, v on the side of n. Ensures 0 where l is not. a is roughness^2, but at least `least`.
vec3 lobeTowards(Lobe lobe, vec3 n, float roughness, vec3 v, vec3 l, float least) {
    precise vec3 sum = v + l;
    precise float square = dot(sum, sum);
    precise vec3 h = sum / sqrt(square > 0.0f ? square : 1.0f);
    precise float nl = dot(n, l);
    precise float nv = max(dot(n, v), 0.0009765625f);
    precise float vh = clamp(dot(v, h), 0.0f, 1.0f);
    precise float a = max(roughness * roughness, least);
    precise float a2 = a * a;
    precise float rest = 1.0f - a2;
    precise float hidden = nl * sqrt(nv * nv * rest + a2) + nv * sqrt(nl * nl * rest + a2);
    precise float c = 1.0f - vh;
    precise float growth = c * c * c * c * c;
    precise vec3 fresnel = lobe.along + (lobe.grazing - lobe.along) * growth;
    precise vec3 value = fresnel * (facetDensity(n, h, a) * 0.5f / hidden);
    return nl > 0.0f ? value : vec3(0.0f);
}

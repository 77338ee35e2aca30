/// Wavefront OBJ and MTL: what of them is read, and how MTL's Phong materials become Material's terms.
///
/// OBJ: v (with an optional w, ignored, and sRGB colour), vt (v counts upwards in OBJ and is turned round), vn, f,
/// usemtl, mtllib; l and p are counted; groups, objects and smoothing groups have no effect: all share one mesh and one
/// count, in file order. Other statements are left out with a remark. Polygons are fanned from their first corner.
///
/// MTL (Kd the diffuse and Ks the specular colour, Ns the exponent, d the opacity, Tf the filter, Ni the index):
///     glass     d < 1 without map_d, or illum 6 or 7 with Tf and Ni > 1.0001: transmission 1, roughness 0, not thin,
///               ior Ni (1.5 if Ni <= 1.0001), baseColor Tf if given, else 1 - d (1 - Kd): the less opaque, the whiter
///     mirror    illum 3, 5 or 8 with Ks > 0: baseColor Kd + Ks (at most 1) and metallic Y(Ks) / Y(Kd + Ks), Y the
///               luminance, so that surfaceOf gives back a mirror of about Ks and a diffuse part of about Kd; roughness
///               sqrt(2 / (Ns + 2)), 0 without Ns: what a ray is traced for is meant to be sharp
///     shine     illum 2 and others with Ks > 0 and Ns: baseColor Kd; a lobe as wide as Phong's, roughness^2 =
///               sqrt(2 / (Ns + 2)) [Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"], but
///               roughness at least 0.5, as exporters write a highlight for nearly everything, and few of those are
///               mirrors; and the index of what reflects 0.08 Y(Ks) along its normal, as Phong's lobes have no energy to go
///               by, and exporters write 0.5 for what reflects 0.04
///     the rest  baseColor Kd, diffuse (roughness 1)
/// emission is Ke. Kd is 0.8 where it is not given, 1 under a map.
///
/// Maps:
///     map_Kd    multiplies Kd
///     map_Ke    multiplies Ke, which is 1 where it is not given under a map that can be read
///     map_d     is coverage, times d: what d < 1 makes glass without it blends. It is the channel that -imfchan names (r,
///               g, b, m alpha, l luminance), else alpha, if any of it is less than 1, else luminance. It becomes the alpha
///               of map_Kd's picture, looked up by map_Kd's options, or without one of a white picture, by its own; of each
///               side the longer one counts, and what is smaller is resampled. Glass by illum stays glass: there map_d is
///               left out with a remark
///     norm      bends the normal as glTF's normal textures do, its x and y multiplied by -bm
///     map_Bump  (or bump) without norm, as norm where its picture is one of normals: exporters write these there, too. Nine
///               of ten texels must then be unit vectors, and not grey. Heights are left out with a remark
/// disp, decal, refl, map_Ks, map_Ns, map_Pr, map_Pm, map_Ps and map_Tr are left out with one remark, all else in silence;
/// map_Ka has no meaning here. Maps that are read repeat; with -clamp on their edge texels go on. -s and -o place them at
/// scale (u, v) + offset of the coordinates as OBJ counts them. Other options are skipped; a map without a file,
/// or whose options are malformed or have numbers beyond what scene.hpp allows, is left out with its line.
#pragma once

#include "scene/scene.hpp"

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace raig {

/// A picture as a statement names it.
struct MtlMap {
    std::string file;  ///< with forward slashes; empty: none
    bool clamps = false;
    vec2 scale{1.0f};       ///< -s
    vec2 offset{0.0f};      ///< -o
    float strength = 1.0f;  ///< -bm: multiplies x and y of normals
    char channel = 0;       ///< -imfchan: r, g, b, m or l; 0 where none of these is stated

    bool isNone() const { return file.empty(); }
};

/// A material as its library states it; what it does not state is empty.
struct MtlMaterial {
    std::string name;
    std::optional<vec3> kd, ks, ke, tf;
    std::optional<float> ns, opacity, ni;
    std::optional<int> illum;
    MtlMap kdMap, keMap, dMap, normMap, bumpMap;
    std::set<std::string_view> otherMaps;  ///< the kinds of those that are not read, as views of constants
};

/// Reads an MTL library. Statements with malformed numbers are left out, each with a remark that begins with "place:line".
/// Cost O(text).
std::vector<MtlMaterial> readMtl(std::string_view text, const std::string& place, std::vector<std::string>& remarks);

/// The mapping above, without the textures. Ensures: all numbers finite and in Material's ranges.
Material toMaterial(const MtlMaterial& material);

/// Reads the libraries that an OBJ file in `folder` names (each a statement's argument: one file name, or several) and
/// appends to `scene` one material for each of `names`, in that order, with their images. An empty name, and one that no
/// library defines, gives a default material. What is missing, unreadable or outside `folder` becomes a remark.
void addMtlMaterials(Scene& scene, const std::filesystem::path& folder, const std::vector<std::string>& libraries,
                     const std::vector<std::string>& names);

}  // namespace raig

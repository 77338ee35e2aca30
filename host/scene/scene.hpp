/// The scene as plain values: what the files said, checked, with nothing of devices or structures in it.
///
/// Lengths are in the file's units, angles in radians, colours linear RGB (images: encoded texels, decoded on use).
#pragma once

#include "base/box.hpp"
#include "base/vectors.hpp"
#include "scene/environment.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raig {

/// An image, row by row from the top, 4 bytes a texel. Whether these are sRGB or linear is up to who looks it up.
struct Texels {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> rgba;
};

enum class Wrap : uint32_t { repeat = 0, clamp = 1, mirror = 2 };

/// What texture coordinates, and the numbers of their transforms, are at most, either way. Beyond it floats cannot tell
/// texels apart, and products of these might overflow.
constexpr float mostUv = 1e9f;
/// The same of the strength of a normal texture.
constexpr float mostNormalScale = 1e6f;

inline bool isUsableUv(const vec2& uv) {
    return std::abs(uv.x) <= mostUv && std::abs(uv.y) <= mostUv;
}

/// A look-up of an image: filtered by the footprint of the ray (see shaders/texture.glsl), uv (0, 0) at the top left corner
/// of the top left texel.
struct Texture {
    uint32_t image = 0;
    Wrap wrapU = Wrap::repeat;
    Wrap wrapV = Wrap::repeat;
    uint32_t set = 0;          ///< 0: Mesh::uvs, 1: Mesh::moreUvs
    vec3 u{1.0f, 0.0f, 0.0f};  ///< where to look: u.x * (the set's u) + u.y * (its v) + u.z (KHR_texture_transform)
    vec3 v{0.0f, 1.0f, 0.0f};

    bool operator==(const Texture&) const = default;
};

/// A surface, in the terms of glTF 2.0; MTL files are mapped onto it (see scene/obj.hpp).
struct Material {
    std::string name;
    vec3 baseColor{0.8f};
    float alpha = 1.0f;         ///< coverage: the rest of the light passes straight on, as if nothing were there
    bool alphaVaries = false;   ///< the base colour texture's alpha and the vertices' multiply it
    float alphaCutoff = 0.0f;   ///< above 0: coverage is 1 where alpha is at least that, else 0
    float metallic = 0.0f;
    float roughness = 1.0f;
    float transmission = 0.0f;                ///< KHR_materials_transmission
    float ior = 1.5f;                         ///< KHR_materials_ior
    bool thin = true;                         ///< no KHR_materials_volume: light passes without being bent
    vec3 attenuationColor{1.0f};              ///< what is left of white light after attenuationDistance inside
    float attenuationDistance = 0;            ///< 0: nothing is absorbed
    vec3 emission{0.0f};                      ///< radiance, strength included
    float normalScale = 1.0f;                 ///< multiplies x and y of the normal texture
    float occlusionStrength = 1.0f;           ///< 0: ambient light as without the texture, 1: as it says
    std::optional<Texture> baseColorTexture;  ///< sRGB, multiplies baseColor
    std::optional<Texture> roughnessTexture;  ///< linear: green multiplies roughness, blue metallic
    std::optional<Texture> normalTexture;     ///< linear: red, green and blue are x, y, z of -1 to 1 about the surface's own
    std::optional<Texture> emissionTexture;   ///< sRGB, multiplies emission
    std::optional<Texture> occlusionTexture;  ///< linear: red multiplies ambient light
};

struct Sphere {
    vec3 centre{0.0f};
    float radius = 0.0f;
};

/// Triangles in file order, then spheres in file order: so a mesh's primitives are numbered. `normals`, `tangents`, `uvs`,
/// `moreUvs`, `colors` and `alphas` are empty or have one entry a vertex. Every index is in range; normals are unit length
/// or zero, and so are tangents, whose w is 1 or -1; no promise is made about positions and spheres (they may be NaN).
struct Mesh {
    std::string name;
    std::vector<vec3> positions;
    std::vector<vec3> normals;
    std::vector<vec4> tangents;  ///< where u grows; v grows along -w times the cross product of normal and tangent
    std::vector<vec2> uvs;
    std::vector<vec2> moreUvs;  ///< a second set
    std::vector<vec3> colors;
    std::vector<float> alphas;  ///< of the colours
    std::vector<uvec3> triangles;
    std::vector<Sphere> spheres;
    std::vector<uint32_t> materials;  ///< one a primitive, an index into Scene::materials

    size_t primitiveCount() const { return triangles.size() + spheres.size(); }
};

/// A mesh put into the world. `toWorld` is finite and affine; it may be singular (its triangles are then dropped). Where the
/// mesh has spheres, it scales all lengths alike (uniformScale() in geometry.hpp).
struct Instance {
    uint32_t mesh = 0;
    dmat4 toWorld{1.0};
};

struct Light {
    enum class Type : uint32_t { point = 0, spot = 1, directional = 2 };
    Type type = Type::point;
    vec3 position{0.0f};
    vec3 direction{0.0f, 0.0f, -1.0f};  ///< unit, in which the light shines
    vec3 intensity{1.0f};               ///< W/sr a channel (point, spot); irradiance W/m^2 (directional)
    float innerConeAngle = 0.0f;        ///< spot: full intensity inside, from the axis
    float outerConeAngle = 0.785398f;   ///< spot: none outside
    bool castsShadows = true;           ///< false: reaches every surface that faces it (a headlight)
    float range = 0.0f;                 ///< 0: unlimited; else no light beyond (KHR_lights_punctual)
};

struct Camera {
    std::string name;
    vec3 eye{0.0f, 0.0f, 1.0f};
    vec3 forward{0.0f, 0.0f, -1.0f};  ///< unit
    vec3 right{1.0f, 0.0f, 0.0f};     ///< unit
    vec3 up{0.0f, 1.0f, 0.0f};        ///< unit, perpendicular to forward and right
    bool orthographic = false;
    float yfov = 0.785398f;          ///< full vertical angle (perspective)
    float xmag = 1.0f, ymag = 1.0f;  ///< half width and height (orthographic)
    float aspect = 0.0f;             ///< width / height the file asks for; 0: that of the picture
    std::optional<vec3> target;      ///< a point that it looks at, where one is known: files name none
};

/// Light from where nothing is: horizon to zenith (world +Y) by height, and below the horizon `ground` to horizon.
struct Sky {
    vec3 zenith{0.0f};
    vec3 horizon{0.0f};
    vec3 ground{0.0f};
};

/// How many primitives cannot be used, by reason. They keep their ids, and no ray hits them.
struct Dropped {
    uint64_t nonFinite = 0;  ///< a corner, or a point of a sphere, is NaN, infinite, or beyond +-1.844e18
    uint64_t zeroArea = 0;   ///< corners coincide or are collinear; a radius is not positive
    uint64_t other = 0;      ///< points, lines, and faces of fewer than 3 corners
};

/// What a file can play.
struct Clip {
    std::string name;
    double seconds = 0.0;  ///< how long it is, as the file declares
};

struct Scene {
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Material> materials;  ///< at least one
    std::vector<Texels> images;
    std::vector<Light> lights;
    std::vector<Camera> cameras;  ///< at least one, once completed
    Sky sky;
    std::optional<Environment> environment;  ///< what is seen instead of the sky, and lights what is there
    vec3 ambient{0.0f};                ///< radiance that reaches every surface from everywhere
    std::vector<Clip> clips;           ///< those of the file, played or not
    uint64_t otherPrimitives = 0;      ///< points, lines, faces of fewer than 3 corners: left out by the importer
    std::vector<std::string> remarks;  ///< what was left out, replaced or assumed, one line each
};

}  // namespace raig

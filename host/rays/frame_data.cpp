#include "rays/frame_data.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "rays/lights.hpp"
#include "rays/textures.hpp"
#include "scene/surface.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace raig {

using namespace shared;

namespace {

uint32_t bitsOf(float x) { return std::bit_cast<uint32_t>(x); }
uvec4 packed(const vec3& v, uint32_t w) { return {bitsOf(v.x), bitsOf(v.y), bitsOf(v.z), w}; }
uvec4 packed(const vec3& v, float w) { return packed(v, bitsOf(w)); }

/// Appends to the array and says where.
class Packer {
public:
    explicit Packer(FrameData& data) : data_(data) {}

    uint32_t here() const { return static_cast<uint32_t>(data_.elements.size()); }
    void append(const uvec4& element) { data_.elements.push_back(element); }
    void append(const std::vector<uvec4>& elements) { std::ranges::copy(elements, room(elements.size()).begin()); }
    /// Room for `count` elements, zero.
    std::span<uvec4> room(size_t count) {
        const size_t first = data_.elements.size();
        if (first + count > 0xffffffffu)
            throw limitError("the scene needs {} elements of shading data; 2^32 fit", first + count);
        data_.elements.resize(first + count);
        return std::span(data_.elements).subspan(first);
    }

private:
    FrameData& data_;
};

/// Of each material, whether anything is made of it. O(primitives).
std::vector<bool> findUsed(const Scene& scene, const Geometry& geometry) {
    std::vector<bool> isUsed(scene.materials.size(), false);
    for (const uint32_t material : geometry.materials) isUsed[material] = true;
    return isUsed;
}

/// Code is left out for what only unused materials ask for.
void packMaterials(const Scene& scene, const std::vector<bool>& isUsed, const TextureList& textures, Packer& packer,
                   FrameData& data) {
    data.params.materialsAt = packer.here();
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& m = scene.materials[i];
        const Surface s = surfaceOf(m);
        const TextureList::Numbers& t = textures.ofMaterial[i];
        const bool transmits = glm::any(glm::greaterThan(s.transmission, vec3(0.0f)));
        const bool covers = !mayLetPass(scene, m);
        const uint32_t flags = (s.thin ? SURFACE_THIN : 0) | (transmits ? SURFACE_TRANSMITS : 0) |
                               (m.alphaVaries && !covers ? SURFACE_ALPHA_VARIES : 0);
        packer.append(packed(m.baseColor, m.metallic));
        packer.append(packed(m.emission, m.roughness));
        packer.append(packed(s.absorption, s.ior));
        packer.append(packed(vec3(m.transmission, covers ? 1.0f : m.alpha, normalReflectance(m.ior)), flags));
        packer.append({t.color, t.roughness, t.normal, t.emission});
        packer.append({t.occlusion, bitsOf(m.occlusionStrength), bitsOf(m.normalScale), uint32_t{data.media.ofMaterial[i]}});
        packer.append({bitsOf(covers ? 0.0f : leastAlpha(m)), 0u, 0u, 0u});
        if (!isUsed[i]) continue;
        if (!covers) data.features |= FEATURE_COVERAGE;
        if (!covers && m.alphaCutoff <= 0.0f) data.features |= FEATURE_BLENDS;
        const bool shines = s.f90 > 0.0f || m.metallic > 0.0f || t.roughness != NO_TEXTURE;
        const bool blurs = !transmits && (s.gloss < 1.0f || t.roughness != NO_TEXTURE);
        if (shines && (blurs || !scene.lights.empty())) data.features |= FEATURE_LOBES;
        if (transmits) data.features |= FEATURE_TRANSMISSION;
        // A texture can only make a surface smoother.
        if (!transmits && (s.gloss > 0.0f || t.roughness != NO_TEXTURE)) data.features |= FEATURE_MIRRORS;
    }
}

void packMedia(Packer& packer, FrameData& data) {
    data.params.mediaAt = packer.here();
    if (!data.media.nests) return;
    data.features |= FEATURE_NESTED;
    for (const Medium& medium : data.media.media) packer.append(packed(medium.absorption, medium.ior));
}

/// One over the sum of the emitters' areas, each times the luminance of its material's emission, as far as floats go; 0 if
/// there are none.
float emitterScale(const Scene& scene, const Geometry& geometry, const std::vector<Emitter>& emitters) {
    double sum = 0.0;
    for (const Emitter& emitter : emitters) {
        const uint32_t material = geometry.materials[geometry.storedTriangle(geometry.place(emitter.triangle))];
        sum += double{emitter.area} * glm::dot(dvec3(0.2126, 0.7152, 0.0722), dvec3(scene.materials[material].emission));
    }
    using Limits = std::numeric_limits<float>;
    return emitters.empty() ? 0.0f : static_cast<float>(std::clamp(1.0 / sum, double{Limits::min()}, double{Limits::max()}));
}

void packLights(const Scene& scene, const Geometry& geometry, Packer& packer, FrameData& data) {
    data.params.lightsAt = packer.here();
    data.params.lightCount = static_cast<uint32_t>(scene.lights.size());
    for (const Light& light : scene.lights) {
        packer.append(packed(light.position, static_cast<uint32_t>(light.type)));
        packer.append(packed(light.direction, light.range));
        packer.append(packed(light.intensity, static_cast<float>(std::cos(double{light.outerConeAngle}))));
        packer.append(
            {bitsOf(static_cast<float>(std::cos(double{light.innerConeAngle}))), light.castsShadows ? 1u : 0u, 0u, 0u});
    }
    const std::vector<Emitter> emitters = listEmitters(scene, geometry);
    data.params.emittersAt = packer.here();
    data.params.emitterCount = static_cast<uint32_t>(emitters.size());
    for (const Emitter& emitter : emitters)
        packer.append({bitsOf(emitter.cumulated), emitter.triangle, bitsOf(emitter.area), 0u});
    data.params.emitterScale = emitterScale(scene, geometry, emitters);
    const bool shines = scene.environment && scene.environment->shines();
    data.params.shadowRays = data.params.lightCount + (emitters.empty() ? 0 : 1) + (shines ? 1 : 0);
    if (!scene.lights.empty()) data.features |= FEATURE_LIGHTS;
    if (!emitters.empty()) data.features |= FEATURE_EMITTERS;
    if (shines) data.features |= FEATURE_SHINING;
}

void packEnvironment(const Scene& scene, Packer& packer, FrameData& data) {
    if (!scene.environment) return;
    const Environment& environment = *scene.environment;
    data.features |= FEATURE_ENVIRONMENT;
    data.params.environmentAt = packer.here();
    data.params.environmentSide = environment.side;
    const std::span<uvec4> elements = packer.room(environment.texels.size() + (environment.side + 3) / 4);
    for (size_t i = 0; i < environment.texels.size(); ++i)
        elements[i] = packed(environment.texels[i], environment.columns[i]);
    for (uint32_t row = 0; row < environment.side; ++row)
        elements[environment.texels.size() + row / 4][row % 4] = environment.rows[row];
}

void packGeometry(const Geometry& geometry, Packer& packer, FrameData& data) {
    const bool normals = !geometry.normals.empty(), colors = !geometry.colors.empty();
    const bool uvs = (data.features & FEATURE_UVS) != 0, moreUvs = (data.features & FEATURE_MORE_UVS) != 0;
    const bool tangents = (data.features & FEATURE_NORMAL_TEXTURES) != 0 && !geometry.tangents.empty();
    if (!geometry.spheres.empty()) data.features |= FEATURE_SPHERES;
    data.features |= (normals ? FEATURE_NORMALS : 0) | (colors ? FEATURE_COLORS : 0) |
                     (tangents ? FEATURE_TANGENTS : 0);

    data.params.trianglesAt = packer.here();
    const std::span<uvec4> triangles = packer.room(geometry.triangles.size());
    parallelFor(triangles.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) triangles[i] = uvec4(geometry.triangles[i], geometry.materials[i]);
    });

    static_assert(Geometry::noVertex == NO_VERTEX);
    data.params.spheresAt = packer.here();
    for (const Sphere& sphere : geometry.spheres) packer.append(packed(sphere.centre, sphere.radius));

    const uint32_t stride = 1 + (normals || uvs ? 1 : 0) + (tangents ? 1 : 0) + (moreUvs ? 1 : 0) + (colors ? 1 : 0);
    data.params.vertexStride = stride;
    data.params.verticesAt = packer.here();
    const std::span<uvec4> vertices = packer.room(geometry.positions.size() * stride);
    parallelFor(geometry.positions.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const vec2 uv = uvs ? geometry.uvs[i] : vec2(0.0f);
            uvec4* vertex = &vertices[i * stride];
            vertex[0] = packed(geometry.positions[i], uv.x);
            if (normals || uvs) vertex[1] = packed(normals ? geometry.normals[i] : vec3(0.0f), uv.y);
            if (tangents) vertex[2] = packed(vec3(geometry.tangents[i]), geometry.tangents[i].w);
            if (moreUvs) vertex[tangents ? 3 : 2] = {std::bit_cast<uvec2>(geometry.moreUvs[i]), 0u, 0u};
            if (colors) vertex[stride - 1] = packed(geometry.colors[i], geometry.alphas.empty() ? 1.0f : geometry.alphas[i]);
        }
    });
}

uvec4 packed(const vec4& v) { return packed(vec3(v), v.w); }

void packInstances(const Geometry& geometry, Packer& packer, FrameData& data) {
    if (!geometry.isInstanced()) return;
    data.features |= FEATURE_INSTANCES;
    data.params.instancesAt = packer.here();
    data.params.instanceCount = static_cast<uint32_t>(geometry.placed.size());
    const std::span<uvec4> records = packer.room(geometry.placed.size() * FRAME_INSTANCE_STRIDE);
    for (size_t i = 0; i < geometry.placed.size(); ++i) {
        const Geometry::Placed& placed = geometry.placed[i];
        const uint32_t firstId = geometry.firstTriangle[i];
        uvec4* record = &records[i * FRAME_INSTANCE_STRIDE];
        record[0] = packed(placed.placement.x);
        record[1] = packed(placed.placement.y);
        record[2] = packed(placed.placement.z);
        record[3] = packed(placed.normalPlacement.x, firstId);
        record[4] = packed(placed.normalPlacement.y, geometry.stored[placed.mesh].firstTriangle - firstId);
        record[5] = packed(placed.normalPlacement.z, placed.firstSphere << 1 | (placed.mirrored ? 1u : 0u));
    }
}

}  // namespace

void setView(const Scene& scene, const FrameOptions& options, FrameParams& params) {
    RAIG_CHECK_OP(options.camera, <, scene.cameras.size());
    const Camera& camera = scene.cameras[options.camera];
    const double aspect = double(options.width) / options.height;
    double halfHeight = std::tan(0.5 * camera.yfov);
    double halfWidth = halfHeight * aspect;
    if (camera.orthographic) {
        halfWidth = std::max<double>(camera.xmag, camera.ymag * aspect);
        halfHeight = std::max<double>(camera.ymag, camera.xmag / aspect);
    }
    params.eye = camera.eye;
    params.forward = camera.forward;
    params.right = camera.right;
    params.up = camera.up;
    params.halfWidth = static_cast<float>(halfWidth);
    params.halfHeight = static_cast<float>(halfHeight);
    params.orthographic = camera.orthographic ? 1 : 0;
    params.width = options.width;
    params.height = options.height;
    const Crop part = options.part();
    params.left = part.x;
    params.top = part.y;
    params.partWidth = part.width;
    params.partHeight = part.height;
    params.lensRadius = 0.5f * options.aperture;
    params.lensSlope = static_cast<float>(0.5 * options.aperture / options.focus);
    params.samples = options.samples;
    params.seed = options.seed;
    params.maxDepth = options.maxDepth;
    params.minContribution = options.minContribution;
    params.reach = std::min(options.reach, FAR_AWAY);
    params.roulette = std::min(rouletteFactor * options.minContribution, 1.0f);
    params.zenith = scene.sky.zenith;
    params.horizon = scene.sky.horizon;
    params.ground = scene.sky.ground;
    params.ambient = scene.ambient;
}

namespace {

/// What the place, the normals and the coverage of a hit are found by. (How vertices are laid out is a matter of the scene's
/// features.)
constexpr uint32_t featuresOfCoverage = FEATURE_COVERAGE | FEATURE_BLENDS | FEATURE_COLORS | FEATURE_COLOR_TEXTURES;
constexpr uint32_t featuresOfShapes = FEATURE_NORMALS | FEATURE_UVS | FEATURE_SPHERES | FEATURE_INSTANCES |
                                      FEATURE_TEXTURES | FEATURE_NORMAL_TEXTURES | FEATURE_TEXTURE_TRANSFORMS |
                                      FEATURE_MORE_UVS | FEATURE_TANGENTS;

}  // namespace

void setView(const Scene& scene, const Geometry& geometry, const FrameOptions& options, FrameData& data) {
    setView(scene, options, data.params);
    data.params.eyeMedia = mediaAround(data.media, geometry, data.params.eye);
}

uint32_t withOptions(uint32_t features, const FrameOptions& options) {
    features &= ~(FEATURE_TENT | FEATURE_GAUSS);
    if (options.filter == Filter::tent) features |= FEATURE_TENT;
    if (options.filter == Filter::gauss) features |= FEATURE_GAUSS;
    return (features & ~FEATURE_LENS) | (options.aperture > 0.0f ? FEATURE_LENS : 0);
}

void takeOptions(const FrameOptions& options, FrameData& data) {
    data.features = data.sceneFeatures;
    data.params.shadowRays = data.sceneShadowRays;
    if (options.integrator == Integrator::ao) {
        const bool covers = (data.features & FEATURE_COVERAGE) == 0;
        data.features = (data.features & (covers ? featuresOfShapes : featuresOfShapes | featuresOfCoverage)) | FEATURE_AO;
        if ((data.features & (FEATURE_NORMAL_TEXTURES | FEATURE_COLOR_TEXTURES)) == 0) data.features &= ~FEATURE_TEXTURES;
        data.params.shadowRays = 1;
    }
    if (options.integrator == Integrator::path) data.features |= FEATURE_PATH;
    data.features = withOptions(data.features, options);
}

FrameData packFrame(const Scene& scene, const Geometry& geometry, bool keepsUvs) {
    FrameData data;
    Packer packer(data);
    const std::vector<bool> isUsed = findUsed(scene, geometry);
    const TextureList textures = listTextures(scene, geometry, isUsed);
    data.features |= textureFeatures(textures);
    if (!geometry.uvs.empty() && keepsUvs) data.features |= FEATURE_UVS;
    data.media = findMedia(scene, geometry);
    packMaterials(scene, isUsed, textures, packer, data);
    packMedia(packer, data);
    packLights(scene, geometry, packer, data);
    if (!textures.entries.empty()) {
        data.params.decodeAt = packer.here();
        packer.append(decodingTable());
        data.params.texturesAt = packer.here();
        packer.append(packTextures(scene, textures));
    }
    packEnvironment(scene, packer, data);
    packGeometry(geometry, packer, data);
    packInstances(geometry, packer, data);
    data.sceneFeatures = data.features;
    data.sceneShadowRays = data.params.shadowRays;
    return data;
}

}  // namespace raig

#include "rays/frame_data.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "rays/lights.hpp"
#include "scene/surface.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <tuple>

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

float decodeSrgb(uint32_t byte) {
    const double c = byte / 255.0;
    return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

/// Numbers each distinct texture of the materials; -1 (NO_TEXTURE) for materials without.
struct TextureList {
    std::vector<Texture> textures;
    std::vector<uint32_t> ofMaterial;
};

TextureList listTextures(const Scene& scene, const Geometry& geometry) {
    TextureList list;
    std::map<std::tuple<uint32_t, Wrap, Wrap>, uint32_t> known;
    for (const Material& material : scene.materials) {
        list.ofMaterial.push_back(NO_TEXTURE);
        if (!material.baseColorTexture || geometry.uvs.empty()) continue;
        const Texture& texture = *material.baseColorTexture;
        const auto [entry, isNew] = known.try_emplace({texture.image, texture.wrapU, texture.wrapV},
                                                      static_cast<uint32_t>(list.textures.size()));
        if (isNew) list.textures.push_back(texture);
        list.ofMaterial.back() = entry->second;
    }
    return list;
}

void packTextures(const Scene& scene, const TextureList& list, Packer& packer, FrameParams& params) {
    if (list.textures.empty()) return;
    params.decodeAt = packer.here();
    for (uint32_t i = 0; i < 256; i += 4)
        packer.append(
            {bitsOf(decodeSrgb(i)), bitsOf(decodeSrgb(i + 1)), bitsOf(decodeSrgb(i + 2)), bitsOf(decodeSrgb(i + 3))});

    params.texturesAt = packer.here();
    std::map<uint32_t, uint32_t> firstOfImage;
    auto next = static_cast<uint32_t>(list.textures.size());
    for (const Texture& texture : list.textures) {
        const Texels& image = scene.images.at(texture.image);
        const auto [entry, isNew] = firstOfImage.try_emplace(texture.image, next);
        if (isNew) next += static_cast<uint32_t>((size_t{image.width} * image.height + 3) / 4);
        const uint32_t wraps = static_cast<uint32_t>(texture.wrapU) | static_cast<uint32_t>(texture.wrapV) << 2;
        packer.append({entry->second, image.width, image.height, wraps});
    }
    const std::span<uvec4> texels = packer.room(next - list.textures.size());
    for (const auto& [image, first] : firstOfImage) {
        const std::vector<uint8_t>& rgba = scene.images[image].rgba;
        std::ranges::copy(rgba, reinterpret_cast<uint8_t*>(&texels[first - list.textures.size()]));
    }
}

void packMaterials(const Scene& scene, const TextureList& textures, Packer& packer, FrameData& data) {
    data.params.materialsAt = packer.here();
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Surface s = surfaceOf(scene.materials[i]);
        const uint32_t flags = (s.thin ? SURFACE_THIN : 0) | (s.tintsMirror ? SURFACE_TINTS_MIRROR : 0) |
                               (s.tintsThrough ? SURFACE_TINTS_THROUGH : 0);
        packer.append(packed(s.diffuse, s.gloss));
        packer.append(packed(s.mirror, s.ior));
        packer.append(packed(s.transmission, flags));
        packer.append(packed(s.absorption, textures.ofMaterial[i]));
        packer.append(packed(s.emission, uint32_t{data.media.ofMaterial[i]}));
        const bool transmits = glm::any(glm::greaterThan(s.transmission, vec3(0.0f)));
        if (transmits) data.features |= FEATURE_TRANSMISSION;
        if (!transmits && s.gloss > 0.0f) data.features |= FEATURE_MIRRORS;
    }
}

void packMedia(Packer& packer, FrameData& data) {
    data.params.mediaAt = packer.here();
    if (!data.media.nests) return;
    data.features |= FEATURE_NESTED;
    for (const Medium& medium : data.media.media) packer.append(packed(medium.absorption, medium.ior));
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
    data.params.shadowRays = data.params.lightCount + (emitters.empty() ? 0 : 1);
    if (!scene.lights.empty()) data.features |= FEATURE_LIGHTS;
    if (!emitters.empty()) data.features |= FEATURE_EMITTERS;
}

void packGeometry(const Geometry& geometry, Packer& packer, FrameData& data) {
    const bool normals = !geometry.normals.empty(), colors = !geometry.colors.empty();
    const bool uvs = (data.features & FEATURE_UVS) != 0;
    if (!geometry.spheres.empty()) data.features |= FEATURE_SPHERES;
    data.features |= (normals ? FEATURE_NORMALS : 0) | (colors ? FEATURE_COLORS : 0);

    data.params.trianglesAt = packer.here();
    const std::span<uvec4> triangles = packer.room(geometry.triangles.size());
    parallelFor(triangles.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) triangles[i] = uvec4(geometry.triangles[i], geometry.materials[i]);
    });

    static_assert(Geometry::noVertex == NO_VERTEX);
    data.params.spheresAt = packer.here();
    for (const Sphere& sphere : geometry.spheres) packer.append(packed(sphere.centre, sphere.radius));

    const uint32_t stride = 1 + (normals || uvs ? 1 : 0) + (colors ? 1 : 0);
    data.params.vertexStride = stride;
    data.params.verticesAt = packer.here();
    const std::span<uvec4> vertices = packer.room(geometry.positions.size() * stride);
    parallelFor(geometry.positions.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const vec2 uv = uvs ? geometry.uvs[i] : vec2(0.0f);
            uvec4* vertex = &vertices[i * stride];
            vertex[0] = packed(geometry.positions[i], uv.x);
            if (normals || uvs) vertex[1] = packed(normals ? geometry.normals[i] : vec3(0.0f), uv.y);
            if (colors) vertex[stride - 1] = packed(geometry.colors[i], 0u);
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
    params.zenith = scene.sky.zenith;
    params.horizon = scene.sky.horizon;
    params.ground = scene.sky.ground;
    params.ambient = scene.ambient;
}

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

FrameData packFrame(const Scene& scene, const Geometry& geometry, bool keepsUvs) {
    FrameData data;
    Packer packer(data);
    const TextureList textures = listTextures(scene, geometry);
    if (!textures.textures.empty()) data.features |= FEATURE_TEXTURES;
    if (!geometry.uvs.empty() && (keepsUvs || !textures.textures.empty())) data.features |= FEATURE_UVS;
    data.media = findMedia(scene, geometry);
    packMaterials(scene, textures, packer, data);
    packMedia(packer, data);
    packLights(scene, geometry, packer, data);
    packTextures(scene, textures, packer, data.params);
    packGeometry(geometry, packer, data);
    packInstances(geometry, packer, data);
    return data;
}

}  // namespace raig

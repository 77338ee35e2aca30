#include "rays/economy.hpp"

#include "base/error.hpp"
#include "device/specialize.hpp"
#include "rays/frame_data.hpp"
#include "rays/kernels.hpp"

#include <fmt/ranges.h>

#include <array>
#include <set>

namespace raig {

using namespace shared;

namespace {

struct Feature {
    uint32_t bits;
    const char* name;
};

constexpr uint32_t textured = FEATURE_UVS | FEATURE_TEXTURES;

/// FEATURE_LENS is a picture's, not a scene's.
constexpr std::array features{
    Feature{FEATURE_NORMALS, "vertex normals"},
    Feature{FEATURE_COLORS, "vertex colours"},
    Feature{textured | FEATURE_COLOR_TEXTURES, "colour textures"},
    Feature{textured | FEATURE_ROUGHNESS_TEXTURES, "roughness textures"},
    Feature{textured | FEATURE_NORMAL_TEXTURES, "normal textures"},
    Feature{textured | FEATURE_EMISSION_TEXTURES, "emissive textures"},
    Feature{textured | FEATURE_OCCLUSION_TEXTURES, "occlusion textures"},
    Feature{FEATURE_MIRRORS, "mirrors"},
    Feature{FEATURE_LOBES, "highlights and rough mirrors"},
    Feature{FEATURE_TRANSMISSION, "glass"},
    Feature{FEATURE_NESTED, "glass in glass"},
    Feature{FEATURE_COVERAGE, "cut-outs"},
    Feature{FEATURE_COVERAGE | FEATURE_BLENDS, "blending"},
    Feature{FEATURE_LIGHTS, "lights"},
    Feature{FEATURE_EMITTERS, "glowing triangles"},
    Feature{FEATURE_ENVIRONMENT | FEATURE_SHINING, "an environment"},
    Feature{FEATURE_SPHERES, "spheres"},
    Feature{FEATURE_INSTANCES, "instances"},
};

uint32_t allFeatures() {
    uint32_t bits = 0;
    for (const Feature& feature : features) bits |= feature.bits;
    return bits;
}

/// Instructions of a module: each says in its first word how many words it has. The header has five.
uint32_t countInstructions(std::span<const uint32_t> spirv) {
    uint32_t count = 0;
    for (size_t at = 5; at < spirv.size(); ++count) {
        const uint32_t words = spirv[at] >> 16;
        RAIG_CHECK_OP(words, >, 0u);
        at += words;
    }
    return count;
}

uint32_t instructionsWith(uint32_t bits) {
    uint32_t sum = 0;
    std::vector<const char*> names = {"begin_storage", "shade_storage", "gather_storage"};
    if ((bits & FEATURE_COVERAGE) != 0) names.push_back("pass_storage");
    for (const char* name : names) {
        const auto spirv = findKernel(name);
        RAIG_CHECK(spirv.has_value());
        sum += countInstructions(vk::specialize(
            name, *spirv, {{/* workgroup size */ 0, 256}, {/* FEATURES */ 1, bits}, {/* SCENE_CHUNKS */ 2, 1}}));
    }
    return sum;
}

uint64_t bytesOf(const Texels& image) { return uint64_t{4} * image.width * image.height; }

void addTextures(const Scene& scene, const Geometry& geometry, Economy& economy) {
    const std::set<uint32_t> used(geometry.materials.begin(), geometry.materials.end());
    std::set<uint32_t> images;
    for (const uint32_t index : used) {
        const Material& m = scene.materials[index];
        for (const std::optional<Texture>& texture :
             {m.baseColorTexture, m.roughnessTexture, m.normalTexture, m.emissionTexture, m.occlusionTexture}) {
            if (!texture || geometry.uvs.empty()) continue;
            economy.namedTextureBytes += bytesOf(scene.images[texture->image]);
            if (images.insert(texture->image).second) economy.textureBytes += bytesOf(scene.images[texture->image]);
        }
    }
}

std::string inMiB(uint64_t bytes) { return fmt::format("{:.2f} MiB", double(bytes) / (1 << 20)); }

}  // namespace

Economy measureEconomy(const Scene& scene, const Geometry& geometry, Integrator integrator) {
    FrameData data = packFrame(scene, geometry);
    takeOptions({.integrator = integrator}, data);
    Economy economy;
    economy.instructions = instructionsWith(data.features);
    economy.allInstructions = instructionsWith(data.features | allFeatures());
    for (const Feature& feature : features) {
        if ((data.features & feature.bits) == feature.bits)
            economy.used.emplace_back(feature.name);
        else
            economy.leftOut.push_back(
                {feature.name, instructionsWith(data.features | feature.bits) - economy.instructions});
    }
    constexpr uint32_t elementBytes = 16;
    economy.vertices = geometry.positions.size();
    economy.vertexBytes = elementBytes * data.params.vertexStride;
    economy.allVertexBytes = elementBytes * mostVertexElements;
    economy.triangles = geometry.primitiveCount();
    economy.storedTriangles = geometry.triangles.size();
    addTextures(scene, geometry, economy);
    return economy;
}

std::vector<std::string> describe(const Economy& economy) {
    std::vector<std::string> lines;
    std::vector<std::string> names;
    for (const LeftOut& each : economy.leftOut) names.push_back(fmt::format("{} ({})", each.name, each.instructions));
    if (!names.empty())
        lines.push_back(
            fmt::format("left out, with the instructions that each would add to shading: {}", fmt::join(names, ", ")));
    lines.push_back(fmt::format("shading has {} instructions of {}", economy.instructions, economy.allInstructions));
    if (economy.vertices > 0 && economy.vertexBytes < economy.allVertexBytes)
        lines.push_back(fmt::format("a vertex has {} bytes of {}: {} saved", economy.vertexBytes, economy.allVertexBytes,
                                    inMiB(economy.vertices * (economy.allVertexBytes - economy.vertexBytes))));
    if (economy.storedTriangles < economy.triangles)
        lines.push_back(fmt::format("{} of {} triangles are in memory, the others are instances of them",
                                    economy.storedTriangles, economy.triangles));
    if (economy.textureBytes < economy.namedTextureBytes)
        lines.push_back(fmt::format("images take {}; a copy for each material that names them would take {}",
                                    inMiB(economy.textureBytes), inMiB(economy.namedTextureBytes)));
    return lines;
}

}  // namespace raig

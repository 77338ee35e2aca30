/// The textures of a scene as the frame's code looks them up: images with their pyramids, each once.
#pragma once

#include "rays/frame_types.hpp"
#include "scene/geometry.hpp"

#include <vector>

namespace raig {

/// The levels of an image's pyramid, itself first, each half as wide and high (rounded down, at least 1) as the one before,
/// down to one texel. A texel is the mean of what it covers of the level before, by area, its first three channels in linear
/// light if they are `encoded` as sRGB, and rounded to a byte, halves upwards. Cost O(texels).
/// Source: Williams 1983, "Pyramidal Parametrics".
std::vector<Texels> pyramidOf(const Texels& image, bool encoded);

/// What materials look up, numbered: two that ask for the same share a number.
struct TextureList {
    struct Entry {
        Texture texture;
        bool encoded;  ///< as sRGB
    };
    /// Of one material; NO_TEXTURE where it has none, or nothing is made of it, or the geometry has no such texture
    /// coordinates.
    struct Numbers {
        uint32_t color = shared::NO_TEXTURE, roughness = color, normal = color, emission = color, occlusion = color;
    };
    std::vector<Entry> entries;
    std::vector<Numbers> ofMaterial;
};
/// `isUsed`: of each material, whether anything is made of it.
TextureList listTextures(const Scene& scene, const Geometry& geometry, const std::vector<bool>& isUsed);

/// FEATURE_* of all that is listed.
uint32_t textureFeatures(const TextureList& list);

/// The elements that shaders/shared/frame.glsl describes as textures, levels and texels.
std::vector<uvec4> packTextures(const Scene& scene, const TextureList& list);

/// What each sRGB byte means in linear light: 64 elements of four floats.
std::vector<uvec4> decodingTable();

}  // namespace raig

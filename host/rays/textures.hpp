/// The textures of a scene as the frame's code looks them up: images with their pyramids, each once.
#pragma once

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
    /// Of one material; NO_TEXTURE where it has none, or the geometry no such texture coordinates.
    struct Numbers {
        uint32_t color, roughness, normal, emission, occlusion;
    };
    std::vector<Entry> entries;
    std::vector<Numbers> ofMaterial;
};
TextureList listTextures(const Scene& scene, const Geometry& geometry);

/// FEATURE_* of all that is listed.
uint32_t textureFeatures(const TextureList& list);

/// The elements that shaders/shared/frame.glsl describes as textures, levels and texels.
std::vector<uvec4> packTextures(const Scene& scene, const TextureList& list);

/// What each sRGB byte means in linear light: 64 elements of four floats.
std::vector<uvec4> decodingTable();

}  // namespace raig

/// Images looked up in double precision, filtered by what a ray covers of them.
#pragma once

#include "scene/scene.hpp"

#include <array>
#include <map>

namespace raig::reference {

/// The pyramids of a scene's images, each made when it is first asked for.
///
/// Level 0 is the image. Each level has floor(n / 2) texels a side, at least 1, where the one before has n, down to one
/// texel; each texel is the mean of what it covers of the level before, by area, its colours in linear light where they are
/// sRGB, and is rounded to the nearest byte of the image's encoding, halves upwards. Source: Williams 1983, "Pyramidal
/// Parametrics".
class Pyramids {
public:
    /// Images and materials must outlive it. Makes what the materials ask for. Cost O(texels).
    explicit Pyramids(const Scene& scene);

    /// The mean of `texture` over a square of side `width` about `uv`, in texture coordinates of the texture's set, before
    /// its transform; red, green and blue in linear light if they are sRGB.
    ///
    /// With x the side in texels, by area: for x <= 1 bilinear in level 0, (0, 0) being the top left corner of the top left
    /// texel. Beyond, with e = floor(log2 x), the bilinear values of levels e and e + 1, mixed by x / 2^e - 1; the last
    /// level stands for those after it.
    dvec4 lookUp(const Texture& texture, bool isSrgb, const dvec2& uv, double width) const;

    /// The mean of a whole image in linear light.
    dvec3 mean(uint32_t image) const;

private:
    struct Level {
        uint32_t width, height;
        std::vector<uint8_t> rgba;
    };
    using Levels = std::vector<Level>;

    Level half(const Level& level, bool isSrgb) const;
    dvec4 decoded(const uint8_t* texel, bool isSrgb) const;
    dvec4 bilinear(const Level& level, const Texture& texture, bool isSrgb, const dvec2& uv) const;

    const Scene* scene_;
    std::array<double, 256> linear_{};
    std::map<std::pair<uint32_t, bool>, Levels> pyramids_;
};

}  // namespace raig::reference

/// From the light of a scene to what a screen shows: exposure, and curves that bend bright light below 1.
#pragma once

#include "image/image.hpp"

#include <optional>
#include <string_view>

namespace raig {

/// How light is shown on a screen.
enum class Tone {
    none,      ///< as it is; what is brighter than 1 is clamped
    reinhard,  ///< x / (1 + x) [Reinhard, Stark, Shirley and Ferwerda 2002, "Photographic Tone Reproduction for Digital
               ///< Images", equation 3]
    filmic,    ///< a film's toe and shoulder, white at 11.2 / 2 [Hable 2010, "Uncharted 2: HDR Lighting", GDC]
    aces,      ///< near the ACES reference rendering transform [Narkowicz 2015, "ACES Filmic Tone Mapping Curve"]
    neutral,   ///< colours up to 0.8 less a reflection's 0.04 as they are, what is brighter compressed and drawn to white
               ///< [Khronos 2024, "Khronos PBR Neutral Tone Mapper"]
};

/// The tone of that name (as above), if there is one.
std::optional<Tone> findTone(std::string_view name);

std::string_view nameOf(Tone tone);

/// All names, in the order of the enumeration.
std::vector<std::string_view> toneNames();

/// Multiplies all light by 2^stops. Whole stops change no bit of a mantissa, unless a number leaves the normal floats.
void expose(Image& image, double stops);

/// Bends the light of each pixel. All but `neutral` bend each channel by itself, so that what is bright turns white.
///
/// Ensures  with `none` nothing changes. Else channels are in [0, 1]: 0 stays 0, what is below 0 becomes 0, infinite light
///          the brightest there is, a pixel with a NaN stays so; of more light of the same colour no channel is darker, but
///          for `neutral`, which draws bright colours to white.
void bend(Image& image, Tone tone);

/// The exposure that suits a picture, in stops: what brings the mean of its luminance's logarithm to the key value 0.18,
/// middle grey [Reinhard et al. 2002, equations 1 and 2]. In place of that paper's constant, pixels that are black or not
/// finite do not count, and none counts as darker than 1/1024 of the mean: so twice the light asks for one stop less.
/// Nothing if no pixel counts. The same bits in every run.
std::optional<double> suitableStops(const Image& image);

}  // namespace raig

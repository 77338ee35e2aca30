/// What can be written of each pixel beside its colour, by name.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace raig {

enum class Aov { depth, position, normal, uv, primitive, instance, material, albedo, samples, level, weight, cost };

struct AovType {
    Aov aov;
    std::string_view name;
    std::vector<std::string> channels;  ///< of the layer, which has the AOV's name
    bool isWhole;                       ///< whole numbers, else floats
    bool isOfPicture;                   ///< known from rendering the picture; else from the ray through the pixel's centre
};

/// All of them, in the order of the enumeration.
std::span<const AovType> aovTypes();
const AovType& typeOf(Aov aov);
/// Nothing where none has that name.
std::optional<Aov> findAov(std::string_view name);

}  // namespace raig

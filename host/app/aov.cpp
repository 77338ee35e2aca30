#include "app/aov.hpp"

#include <algorithm>

namespace raig {

std::span<const AovType> aovTypes() {
    static const std::vector<AovType> types = {
        {Aov::depth, "depth", {"Z"}, false, false},
        {Aov::position, "position", {"X", "Y", "Z"}, false, false},
        {Aov::normal, "normal", {"X", "Y", "Z"}, false, false},
        {Aov::uv, "uv", {"U", "V"}, false, false},
        {Aov::primitive, "primitive", {"ID"}, true, false},
        {Aov::instance, "instance", {"ID"}, true, false},
        {Aov::material, "material", {"ID"}, true, false},
        {Aov::albedo, "albedo", {"R", "G", "B"}, false, false},
        {Aov::samples, "samples", {"N"}, true, true},
        {Aov::level, "level", {"N"}, true, true},
        {Aov::weight, "weight", {"Y"}, false, true},
        {Aov::cost, "cost", {"N"}, true, true},
    };
    return types;
}

const AovType& typeOf(Aov aov) {
    return aovTypes()[static_cast<size_t>(aov)];
}

std::optional<Aov> findAov(std::string_view name) {
    const auto found = std::ranges::find(aovTypes(), name, &AovType::name);
    return found == aovTypes().end() ? std::nullopt : std::optional(found->aov);
}

}  // namespace raig

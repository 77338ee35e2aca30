#include "reference/rounding.hpp"

#include "reference/sampling.hpp"

#include <limits>

namespace raig::reference {

double floatUlp(double x) {
    return std::ldexp(1.0,
                      std::max(std::ilogb(std::max(std::abs(x), double{std::numeric_limits<float>::min()})), -126) - 23);
}

Rounding::Rounding(uint32_t pixel, uint32_t sample, uint32_t variant)
    : seed_(hash(hash(pixel, sample), variant / 2)), sign_(variant % 2 == 0 ? 1.0 : -1.0) {}

/// Each component 2 to 4 in size, with a random sign.
dvec3 Rounding::shift(uint32_t key) const {
    dvec3 result;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint32_t bits = hash(hash(seed_, key), axis);
        const double size = 2.0 + (bits >> 8) * 0x1p-23;
        result[axis] = sign_ * ((bits & 1u) ? size : -size);
    }
    return result;
}

dvec3 Rounding::position(const dvec3& p, double magnitude, uint32_t key) const {
    return sign_ == 0.0 ? p : p + floatUlp(magnitude) * shift(key);
}

dvec3 Rounding::direction(const dvec3& d, uint32_t key) const {
    return sign_ == 0.0 ? d : glm::normalize(d + 0x1p-24 * shift(key));
}

}  // namespace raig::reference

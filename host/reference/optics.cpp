#include "reference/optics.hpp"

namespace raig::reference {

double fresnel(double cosI, double n1, double n2) {
    if (n1 == n2) return 0.0;
    const double eta = n1 / n2;
    const double squaredSinT = eta * eta * (1.0 - cosI * cosI);
    if (squaredSinT > 1.0) return 1.0;
    const double cosT = std::sqrt(1.0 - squaredSinT);
    const double perpendicular = (n1 * cosI - n2 * cosT) / (n1 * cosI + n2 * cosT);
    const double parallel = (n2 * cosI - n1 * cosT) / (n2 * cosI + n1 * cosT);
    return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

dvec3 reflect(const dvec3& d, const dvec3& n) {
    return d - 2.0 * glm::dot(d, n) * n;
}

std::optional<dvec3> refract(const dvec3& d, const dvec3& n, double eta) {
    const double cosI = -glm::dot(d, n);
    const double squaredCosT = 1.0 - eta * eta * (1.0 - cosI * cosI);
    if (squaredCosT < 0.0) return std::nullopt;
    return eta * d + (eta * cosI - std::sqrt(squaredCosT)) * n;
}

}  // namespace raig::reference

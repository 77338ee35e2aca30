#include "reference/lobe.hpp"

#include "reference/directions.hpp"
#include "reference/optics.hpp"

#include <algorithm>
#include <cmath>

namespace raig::reference {

LobeAlbedo lobeAlbedo(double cosine, double roughness) {
    const double mu = std::clamp(cosine, 0.0, 1.0), s = std::sqrt(mu), c = 1.0 - mu, r = roughness;
    const dvec3 roots(1.0, s, mu), powers(1.0, c, c * c);
    const double lost = r * glm::dot(roots, dvec3(1.197116, -2.842857, 1.264805)) +
                        r * r * glm::dot(roots, dvec3(-3.802190, 12.473374, -7.462394)) +
                        r * r * r * glm::dot(roots, dvec3(2.595462, -8.787570, 6.086005));
    const double grazing = c * c * c *
                           (glm::dot(powers, dvec3(-3.206164, 8.244979, -3.961959)) +
                            r * glm::dot(powers, dvec3(9.963692, -22.844650, 10.347438)) +
                            r * r * glm::dot(powers, dvec3(-6.954611, 14.808764, -6.313605)));
    const double all = std::clamp(1.0 - lost, 0.25, 1.0);
    return {all, std::clamp(grazing, 0.0, all)};
}

Lobe lobeOf(const LocalSurface& s, double albedo) {
    const double lost = (1.0 - albedo) / albedo;
    const double ofDielectric = (1.0 - s.metallic) * (1.0 + s.dielectric * lost);
    const dvec3 ofMetal = s.metallic * (1.0 + s.metal * lost);
    return {ofDielectric * s.dielectric + ofMetal * s.metal, ofDielectric * s.grazing + ofMetal};
}

dvec3 lobeTowards(const Lobe& lobe, const dvec3& n, double roughness, const dvec3& eye, const dvec3& light,
                  double leastSpread) {
    constexpr double pi = 3.14159265358979323846;
    const double nl = glm::dot(n, light), nv = std::max(glm::dot(n, eye), 1.0 / 1024.0);
    if (nl <= 0.0 || light + eye == dvec3(0.0)) return dvec3(0.0);
    const dvec3 h = glm::normalize(light + eye);
    const double a = std::max(roughness * roughness, leastSpread), nh = glm::dot(n, h);
    const double d = a * a / (pi * std::pow(nh * nh * (a * a - 1.0) + 1.0, 2.0));
    const auto lambda = [&](double cosine) {
        return 0.5 * (std::sqrt(1.0 + a * a * (1.0 / (cosine * cosine) - 1.0)) - 1.0);
    };
    const double g = 1.0 / (1.0 + lambda(nl) + lambda(nv));
    const double growth = std::pow(1.0 - std::clamp(glm::dot(eye, h), 0.0, 1.0), 5.0);
    return (lobe.along + (lobe.grazing - lobe.along) * growth) * (d * g / (4.0 * nl * nv));
}

dvec3 mirroredDirection(const dvec3& n, double a, const dvec3& eye, const dvec2& square) {
    const dvec3 seen = alongNormal(n, eye);
    const dvec3 stretched = glm::normalize(dvec3(a * seen.x, a * seen.y, seen.z));
    const dvec2 disk = inDisk(square);
    // Where the cap's height is even in the square of the radius.
    const double within = glm::dot(disk, disk), z = 1.0 - within * (1.0 + stretched.z);
    const double aside = within > 0.0 ? std::sqrt(std::max(0.0, 1.0 - z * z) / within) : 0.0;
    const dvec3 h = dvec3(aside * disk, z) + stretched;
    dvec3 facet(a * h.x, a * h.y, std::max(0.0, h.z));
    if (facet == dvec3(0.0)) facet.z = 1.0;
    return glm::normalize(aboutNormal(n, reflect(-seen, glm::normalize(facet))));
}

double mirroredDensity(const dvec3& n, double a, const dvec3& eye, const dvec3& light) {
    using std::numbers::pi;
    const double nv = std::max(glm::dot(n, eye), 1.0 / 1024.0), nh = glm::dot(n, glm::normalize(eye + light));
    const double d = a * a / (pi * std::pow(nh * nh * (a * a - 1.0) + 1.0, 2.0));
    const double g1 = 2.0 / (1.0 + std::sqrt(1.0 + a * a * (1.0 / (nv * nv) - 1.0)));
    return d * g1 / (4.0 * nv);
}

}  // namespace raig::reference

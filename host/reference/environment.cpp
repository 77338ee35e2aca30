#include "reference/environment.hpp"

#include <algorithm>

namespace raig::reference {

namespace {

/// Where the entry is that `x`, as a share of the whole, falls on, and what share it has.
struct Drawn {
    size_t index;
    double share;
};

Drawn draw(std::span<const uint32_t> cumulated, double x) {
    const auto at = std::ranges::upper_bound(cumulated, static_cast<uint32_t>(x * Environment::whole));
    const auto index = static_cast<size_t>(at - cumulated.begin());
    const uint32_t before = index == 0 ? 0 : cumulated[index - 1];
    return {index, double(cumulated[index] - before) / Environment::whole};
}

/// The point of the octahedron |x| + |y| + |z| = 1 that (u, v) of [-1, 1]^2 folds to.
dvec3 folded(const dvec2& uv) {
    const double y = 1.0 - std::abs(uv.x) - std::abs(uv.y);
    if (y >= 0.0) return {uv.x, y, uv.y};
    return {std::copysign(1.0 - std::abs(uv.y), uv.x), y, std::copysign(1.0 - std::abs(uv.x), uv.y)};
}

/// The row and column of the texel that unit vector d points to.
std::pair<size_t, size_t> texelAt(const Environment& environment, const dvec3& d) {
    dvec3 q = d / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    if (q.y < 0.0) q = {std::copysign(1.0 - std::abs(q.z), q.x), q.y, std::copysign(1.0 - std::abs(q.x), q.z)};
    const auto texel = [&](double x) {
        return std::min<size_t>(static_cast<size_t>((x + 1.0) / 2.0 * environment.side), environment.side - 1);
    };
    return {texel(q.z), texel(q.x)};
}

}  // namespace

dvec3 distantRadiance(const Scene& scene, const dvec3& d) {
    if (!scene.environment) return skyRadiance(scene.sky, d);
    const Environment& environment = *scene.environment;
    const auto [row, column] = texelAt(environment, d);
    return environment.texels[row * environment.side + column];
}

double environmentDensity(const Environment& environment, const dvec3& d) {
    const auto [row, column] = texelAt(environment, d);
    const auto share = [](std::span<const uint32_t> cumulated, size_t i) {
        return double(cumulated[i] - (i == 0 ? 0 : cumulated[i - 1])) / Environment::whole;
    };
    const size_t side = environment.side;
    const double chance =
        share(environment.rows, row) * share(std::span(environment.columns).subspan(row * side, side), column);
    return chance * std::pow(side / 2.0, 2.0) / std::pow(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), 3.0);
}

Arriving arrivingFromEnvironment(const Environment& environment, const dvec2& rowAndColumn, const dvec2& place,
                                 const dvec3& shadingNormal) {
    const size_t side = environment.side;
    const Drawn row = draw(environment.rows, rowAndColumn.x);
    const Drawn column = draw(std::span(environment.columns).subspan(row.index * side, side), rowAndColumn.y);
    const dvec2 corner(double(column.index), double(row.index));
    const dvec3 point = folded((corner + place) * 2.0 / double(side) - 1.0);
    const double distance = glm::length(point);
    // A texel is (2 / side)^2 of the square, of which du dv has the solid angle du dv / distance^3.
    const double chance = row.share * column.share * std::pow(side / 2.0, 2.0) * std::pow(distance, 3.0);
    Arriving result;
    result.isFar = result.isDrawn = true;
    result.density = chance;
    result.direction = point / distance;
    const dvec3 radiance = environment.texels[row.index * side + column.index];
    result.irradiance = radiance * (std::max(0.0, glm::dot(shadingNormal, result.direction)) / chance);
    return result;
}

}  // namespace raig::reference

#include "reference/world.hpp"

#include "base/error.hpp"

#include <algorithm>

namespace raig::reference {

namespace {

struct Corners {
    uvec3 index;
    dvec3 a, b, c;
};

Corners cornersOf(const Geometry& geometry, uint32_t triangle) {
    const uvec3 t = geometry.triangles[triangle];
    return {t, geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]};
}

/// The mean of three corners' values, weighted by barycentric coordinates.
template <class Value>
auto blend(const std::vector<Value>& values, const uvec3& t, const dvec3& weights) {
    using Wide = glm::vec<Value::length(), double>;
    return weights.x * Wide(values[t.x]) + weights.y * Wide(values[t.y]) + weights.z * Wide(values[t.z]);
}

double largest(const dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// False where the texture coordinates are missing that the texture is looked up by.
bool has(const Geometry& geometry, const std::optional<Texture>& texture) {
    return texture && !(texture->set == 0 ? geometry.uvs : geometry.moreUvs).empty();
}

Emitters findEmitters(const Scene& scene, const Geometry& geometry, const Pyramids& pyramids) {
    Emitters emitters;
    std::vector<dvec3> radiance;
    for (const Material& material : scene.materials) {
        radiance.emplace_back(material.emission);
        if (has(geometry, material.emissionTexture)) radiance.back() *= pyramids.mean(material.emissionTexture->image);
    }
    std::vector<double> sums;
    double sum = 0.0;
    for (uint32_t id = 0; id < geometry.triangles.size(); ++id) {
        const dvec3 emission = radiance[geometry.materials[id]];
        if (emission == dvec3(0.0)) continue;
        if (geometry.isSphere(id)) continue;  // seen to glow, but no light
        const uvec3 t = geometry.triangles[id];
        if (!raig::isUsable(geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z])) continue;
        const Corners corners = cornersOf(geometry, id);
        const double area = 0.5 * glm::length(glm::cross(corners.b - corners.a, corners.c - corners.a));
        sum += area * glm::dot(dvec3(0.2126, 0.7152, 0.0722), emission);
        const dvec3 plain = scene.materials[geometry.materials[id]].emission;
        emitters.glow += area * glm::dot(dvec3(0.2126, 0.7152, 0.0722), plain);
        emitters.triangles.push_back(id);
        emitters.areas.push_back(area);
        sums.push_back(sum);
    }
    for (const double partial : sums) emitters.cumulative.push_back(static_cast<float>(partial / sum));
    if (!sums.empty()) emitters.cumulative.back() = 1.0f;
    return emitters;
}

/// On the side of `normal`.
dvec3 liftOf(const Geometry& geometry, const Corners& corners, const dvec3& weights, const dvec3& point,
             const dvec3& normal) {
    if (geometry.normals.empty()) return dvec3(0.0);
    const std::array<dvec3, 3> at{corners.a, corners.b, corners.c};
    std::array<dvec3, 3> normals;
    for (int i = 0; i < 3; ++i) normals[i] = geometry.normals[corners.index[i]];
    const double side = glm::dot(normals[0] + normals[1] + normals[2], normal) < 0.0 ? -1.0 : 1.0;
    dvec3 lift(0.0);
    for (int i = 0; i < 3; ++i)
        lift -= weights[i] * std::min(0.0, side * glm::dot(point - at[i], normals[i])) * side * normals[i];
    return glm::dot(lift, normal) > 0.0 ? lift : dvec3(0.0);
}

dvec3 interpolatedNormal(const Geometry& geometry, const uvec3& t, const dvec3& weights, const dvec3& otherwise) {
    if (geometry.normals.empty()) return otherwise;
    for (int i = 0; i < 3; ++i)
        if (geometry.normals[t[i]] == vec3(0.0f)) return otherwise;
    const dvec3 sum = blend(geometry.normals, t, weights);
    return glm::length(sum) < 1e-3 ? otherwise : sum / glm::length(sum);
}

}  // namespace

World::World(const Scene& s, const Geometry& g) : scene(s), geometry(g), tree(g), pyramids(s) {
    for (const Material& material : scene.materials) {
        surfaces.push_back(surfaceOf(material));
        seeThrough.push_back(largest(surfaces.back().transmission) > 0.0);
        mayPass.push_back(mayLetPass(scene, material));
        anyPass |= mayPass.back() != 0;
    }
    media = closedMedia(geometry, surfaces);
    emitters = findEmitters(scene, geometry, pyramids);
}

namespace {

/// A triangle, where on it, and how wide the ray is across.
struct Place {
    const World& world;
    uint32_t material;
    Corners corners;
    dvec3 weights{0.0};
    double width = 0.0;
    double cosine = 1.0;

    std::array<dvec2, 3> uvs(const Texture& texture) const {
        const std::vector<vec2>& all = texture.set == 0 ? world.geometry.uvs : world.geometry.moreUvs;
        return {all[corners.index.x], all[corners.index.y], all[corners.index.z]};
    }
};

/// The texture's value, or 1 where there is none.
dvec4 lookUp(const Place& p, const std::optional<Texture>& texture, bool isSrgb) {
    if (!has(p.world.geometry, texture)) return dvec4(1.0);
    const auto [a, b, c] = p.uvs(*texture);
    const dvec2 e = b - a, f = c - a;
    const double area = glm::length(glm::cross(p.corners.b - p.corners.a, p.corners.c - p.corners.a));
    const double covered = p.width / p.cosine * std::sqrt(std::abs(e.x * f.y - f.x * e.y) / area);
    return p.world.pyramids.lookUp(*texture, isSrgb, p.weights.x * a + p.weights.y * b + p.weights.z * c, covered);
}

dvec3 emissionAt(const Place& p) {
    const Material& m = p.world.scene.materials[p.material];
    return dvec3(m.emission) * dvec3(lookUp(p, m.emissionTexture, true));
}

/// Where alpha is `varying` times the material's.
double coverageOf(const World& world, uint32_t material, double varying) {
    if (world.mayPass[material] == 0) return 1.0;
    const Material& m = world.scene.materials[material];
    const double alpha = m.alpha * (m.alphaVaries ? varying : 1.0);
    return m.alphaCutoff > 0.0f ? (alpha >= leastAlpha(m) ? 1.0 : 0.0) : alpha;
}

double vertexAlpha(const Geometry& geometry, const uvec3& t, const dvec3& weights) {
    const std::vector<float>& a = geometry.alphas;
    return a.empty() ? 1.0 : weights.x * a[t.x] + weights.y * a[t.y] + weights.z * a[t.z];
}

double coverageAt(const Place& p) {
    const double texture = lookUp(p, p.world.scene.materials[p.material].baseColorTexture, true).w;
    return coverageOf(p.world, p.material, texture * vertexAlpha(p.world.geometry, p.corners.index, p.weights));
}

/// Applies the formulas of scene/surface.hpp to factors that vary over the surface.
LocalSurface reduce(const World& world, uint32_t material, const dvec3& base, double metallic, double roughness) {
    const Material& m = world.scene.materials[material];
    const Surface& constant = world.surfaces[material];
    LocalSurface s;
    s.gloss = std::pow(std::max(0.0, 1.0 - 2.0 * roughness), 2.0);
    s.roughness = roughness;
    s.diffuse = base * ((1.0 - metallic) * (1.0 - m.transmission));
    s.metallic = metallic;
    s.metal = base;
    const double along = std::pow((m.ior - 1.0) / (m.ior + 1.0), 2.0);
    const double shine = 1.0 - std::pow(std::max(0.0, 2.0 * roughness - 1.0), 2.0);
    s.dielectric = shine * along;
    s.grazing = shine * std::min(1.0, 50.0 * along);
    s.transmits = largest(constant.transmission) > 0.0;
    s.transmission = (1.0 - metallic) * m.transmission * base;
    s.ior = constant.ior;
    s.thin = constant.thin;
    s.absorption = constant.absorption;
    s.emission = m.emission;
    return s;
}

/// Along the texture's u on the front of a triangle, and 1 or -1: whether y, seen from the front, is a quarter turn against
/// the clock from it, or with it.
std::pair<dvec3, double> tangentAt(const Place& p, const Texture& texture) {
    const std::vector<vec4>& tangents = p.world.geometry.tangents;
    const uvec3 t = p.corners.index;
    if (!tangents.empty() && tangents[t.x].w != 0.0f && tangents[t.y].w != 0.0f && tangents[t.z].w != 0.0f)
        return {dvec3(blend(tangents, t, p.weights)), tangents[t.x].w};
    const auto [a, b, c] = p.uvs(texture);
    const glm::dmat2 transform(texture.u.x, texture.v.x, texture.u.y, texture.v.y);
    const dvec2 e = transform * (b - a), f = transform * (c - a);
    const double turn = e.x * f.y - f.x * e.y;
    if (turn == 0.0) return {dvec3(0.0), 1.0};
    const dvec3 alongU = (f.y * (p.corners.b - p.corners.a) - e.y * (p.corners.c - p.corners.a)) / turn;
    return {glm::normalize(alongU), turn > 0.0 ? -1.0 : 1.0};
}

/// `normal` is that of the front.
dvec3 bentNormal(const Place& p, const dvec3& normal) {
    const Material& m = p.world.scene.materials[p.material];
    if (!has(p.world.geometry, m.normalTexture)) return normal;
    const auto [tangent, hand] = tangentAt(p, *m.normalTexture);
    const dvec3 across = tangent - glm::dot(normal, tangent) * normal;
    if (!(glm::dot(across, across) > 1e-6)) return normal;
    const dvec3 x = glm::normalize(across), y = hand * glm::cross(normal, x);
    const dvec3 value = 2.0 * dvec3(lookUp(p, m.normalTexture, false)) - 1.0;
    const dvec3 sum = double{m.normalScale} * (value.x * x + value.y * y) + value.z * normal;
    return glm::dot(sum, sum) > 1e-6 ? glm::normalize(sum) : normal;
}

}  // namespace

namespace {

/// Without texture or vertex colours; the point is brought onto the sphere.
SurfacePoint pointOnSphere(const World& world, const Ray& ray, const Hit& hit) {
    const Sphere& sphere = world.geometry.sphere(hit.primitive);
    const dvec3 centre(sphere.centre);
    SurfacePoint p{};
    const uint32_t material = world.geometry.materials[hit.primitive];
    const Material& m = world.scene.materials[material];
    p.surface = reduce(world, material, m.baseColor, m.metallic, m.roughness);
    p.surface.coverage = coverageOf(world, material, 1.0);
    p.medium = world.media[material];
    p.faceNormal = glm::normalize(ray.origin + hit.t * ray.direction - centre);
    p.position = centre + double{sphere.radius} * p.faceNormal;
    p.front = glm::dot(ray.direction, p.faceNormal) < 0.0;
    p.normal = p.smoothNormal = p.shadingNormal = p.front ? p.faceNormal : -p.faceNormal;
    p.magnitude = std::max(largest(centre), largest(centre - ray.origin)) + sphere.radius;
    return p;
}

}  // namespace

SurfacePoint surfaceAt(const World& world, const Ray& ray, const Hit& hit, double width) {
    const Geometry& geometry = world.geometry;
    if (geometry.isSphere(hit.primitive)) return pointOnSphere(world, ray, hit);
    const Corners corners = cornersOf(geometry, hit.primitive);
    const dvec3 weights(1.0 - hit.u - hit.v, hit.u, hit.v);
    const uint32_t material = geometry.materials[hit.primitive];

    SurfacePoint p{};
    p.medium = world.media[material];
    p.position = weights.x * corners.a + weights.y * corners.b + weights.z * corners.c;
    p.faceNormal = glm::normalize(glm::cross(corners.b - corners.a, corners.c - corners.a));
    p.front = glm::dot(ray.direction, p.faceNormal) < 0.0;
    p.normal = p.front ? p.faceNormal : -p.faceNormal;
    const Place place{world, material, corners, weights, width, std::abs(glm::dot(ray.direction, p.faceNormal))};
    const double side = p.front ? 1.0 : -1.0;
    p.shadingNormal = interpolatedNormal(geometry, corners.index, weights, p.normal);
    if (glm::dot(p.shadingNormal, p.normal) < 0.0) p.shadingNormal = -p.shadingNormal;
    p.smoothNormal = p.shadingNormal;
    p.lift = liftOf(geometry, corners, weights, p.position, p.normal);
    p.shadingNormal = side * bentNormal(place, side * p.shadingNormal);
    const double lacking = 1.0 / 1024.0 + glm::dot(p.shadingNormal, ray.direction);
    if (lacking > 0.0 && p.shadingNormal != p.normal)
        p.shadingNormal = glm::normalize(p.shadingNormal - lacking * ray.direction);
    for (const dvec3& corner : {corners.a, corners.b, corners.c})
        p.magnitude = std::max({p.magnitude, largest(corner), largest(corner - ray.origin)});

    const Material& m = world.scene.materials[material];
    const dvec4 color = lookUp(place, m.baseColorTexture, true);
    dvec3 base = dvec3(m.baseColor) * dvec3(color);
    if (!geometry.colors.empty()) base *= blend(geometry.colors, corners.index, weights);
    const dvec4 rough = lookUp(place, m.roughnessTexture, false);
    p.surface = reduce(world, material, base, m.metallic * rough.z, m.roughness * rough.y);
    p.surface.emission = emissionAt(place);
    p.surface.coverage = coverageOf(world, material, color.w * vertexAlpha(geometry, corners.index, weights));
    p.surface.openness = 1.0 + m.occlusionStrength * (lookUp(place, m.occlusionTexture, false).x - 1.0);
    return p;
}

double coverageAt(const World& world, const Hit& hit) {
    const uint32_t material = world.geometry.materials[hit.primitive];
    if (world.geometry.isSphere(hit.primitive)) return coverageOf(world, material, 1.0);
    return coverageAt({world, material, cornersOf(world.geometry, hit.primitive), dvec3(1.0 - hit.u - hit.v, hit.u, hit.v)});
}

dvec3 skyRadiance(const Sky& sky, const dvec3& d) {
    const dvec3 end = d.y >= 0.0 ? sky.zenith : sky.ground;
    return glm::mix(dvec3(sky.horizon), end, std::abs(d.y));
}

Arriving arriving(const Light& light, const dvec3& position, const dvec3& shadingNormal) {
    Arriving result;
    result.castsShadows = light.castsShadows;
    if (light.type == Light::Type::directional) {
        result.isFar = true;
        result.direction = -dvec3(light.direction);
        result.irradiance = dvec3(light.intensity) * std::max(0.0, glm::dot(shadingNormal, result.direction));
        return result;
    }
    const dvec3 v = dvec3(light.position) - position;
    const double squared = glm::dot(v, v), distance = std::sqrt(squared);
    if (distance == 0.0) return result;
    result.position = light.position;
    result.direction = v / distance;
    double share = std::max(0.0, glm::dot(shadingNormal, result.direction)) / squared;
    if (light.range > 0.0f) share *= std::clamp(1.0 - std::pow(distance / light.range, 4.0), 0.0, 1.0);
    if (light.type == Light::Type::spot) {
        const double inner = std::cos(double{light.innerConeAngle}), outer = std::cos(double{light.outerConeAngle});
        const double angle = -glm::dot(result.direction, dvec3(light.direction));
        const double ramp = inner > outer ? std::clamp((angle - outer) / (inner - outer), 0.0, 1.0) : angle >= outer;
        share *= ramp * ramp;
    }
    result.irradiance = dvec3(light.intensity) * share;
    return result;
}

double glowOf(const World& world, uint32_t material) {
    return glm::dot(dvec3(0.2126, 0.7152, 0.0722), dvec3(world.scene.materials[material].emission)) / world.emitters.glow;
}

Arriving arrivingFromEmitters(const World& world, double choice, const dvec2& place, const dvec3& position,
                              const dvec3& shadingNormal) {
    const Emitters& emitters = world.emitters;
    RAIG_CHECK(!emitters.triangles.empty());
    const auto chosen = std::upper_bound(emitters.cumulative.begin(), emitters.cumulative.end(), choice);
    const auto i = std::min<size_t>(chosen - emitters.cumulative.begin(), emitters.triangles.size() - 1);
    const double chance = double{emitters.cumulative[i]} - (i > 0 ? double{emitters.cumulative[i - 1]} : 0.0);

    const Corners corners = cornersOf(world.geometry, emitters.triangles[i]);
    const double root = std::sqrt(place.x);
    Arriving result;
    result.triangle = emitters.triangles[i];
    result.position = (1.0 - root) * corners.a + root * (1.0 - place.y) * corners.b + root * place.y * corners.c;
    const dvec3 v = result.position - position;
    const double squared = glm::dot(v, v);
    if (squared == 0.0) return result;
    result.direction = v / std::sqrt(squared);
    const dvec3 normal = glm::normalize(glm::cross(corners.b - corners.a, corners.c - corners.a));
    const double cosines =
        std::max(0.0, glm::dot(shadingNormal, result.direction)) * std::abs(glm::dot(normal, result.direction));
    const dvec3 weights((1.0 - root), root * (1.0 - place.y), root * place.y);
    const Place there{world, world.geometry.materials[result.triangle], corners, weights};
    result.isDrawn = true;
    result.density = glowOf(world, there.material) * squared / std::abs(glm::dot(normal, result.direction));
    result.irradiance = coverageAt(there) * emissionAt(there) * (cosines / squared / (chance / emitters.areas[i]));
    return result;
}

}  // namespace raig::reference

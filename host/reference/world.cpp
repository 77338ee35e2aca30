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

Emitters findEmitters(const Geometry& geometry, const std::vector<Surface>& surfaces) {
    Emitters emitters;
    std::vector<double> sums;
    double sum = 0.0;
    for (uint32_t id = 0; id < geometry.triangles.size(); ++id) {
        const dvec3 emission = surfaces[geometry.materials[id]].emission;
        if (emission == dvec3(0.0)) continue;
        if (geometry.isSphere(id)) continue;  // seen to glow, but no light
        const uvec3 t = geometry.triangles[id];
        if (!raig::isUsable(geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z])) continue;
        const Corners corners = cornersOf(geometry, id);
        const double area = 0.5 * glm::length(glm::cross(corners.b - corners.a, corners.c - corners.a));
        sum += area * glm::dot(dvec3(0.2126, 0.7152, 0.0722), emission);
        emitters.triangles.push_back(id);
        emitters.areas.push_back(area);
        sums.push_back(sum);
    }
    for (const double partial : sums) emitters.cumulative.push_back(static_cast<float>(partial / sum));
    if (!sums.empty()) emitters.cumulative.back() = 1.0f;
    return emitters;
}

/// Texel `index` of `count`, carried back into the image.
uint32_t wrapped(double index, uint32_t count, Wrap wrap) {
    const double size = count;
    if (wrap == Wrap::clamp) return static_cast<uint32_t>(std::clamp(index, 0.0, size - 1.0));
    const double period = wrap == Wrap::mirror ? 2.0 * size : size;
    double place = index - std::floor(index / period) * period;
    if (place >= period) place = 0.0;  // index / period rounded
    return static_cast<uint32_t>(place < size ? place : 2.0 * size - 1.0 - place);
}

dvec3 interpolatedNormal(const Geometry& geometry, const uvec3& t, const dvec3& weights, const dvec3& otherwise) {
    if (geometry.normals.empty()) return otherwise;
    for (int i = 0; i < 3; ++i)
        if (geometry.normals[t[i]] == vec3(0.0f)) return otherwise;
    const dvec3 sum = blend(geometry.normals, t, weights);
    return glm::length(sum) < 1e-3 ? otherwise : sum / glm::length(sum);
}

}  // namespace

World::World(const Scene& s, const Geometry& g) : scene(s), geometry(g), tree(g) {
    for (const Material& material : scene.materials) {
        surfaces.push_back(surfaceOf(material));
        seeThrough.push_back(largest(surfaces.back().transmission) > 0.0);
    }
    media = closedMedia(geometry, surfaces);
    emitters = findEmitters(geometry, surfaces);
    for (int byte = 0; byte < 256; ++byte) {
        const double encoded = byte / 255.0;
        linear[byte] = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    }
}

dvec3 textureColour(const World& world, const Texture& texture, const dvec2& uv) {
    const Texels& image = world.scene.images[texture.image];
    const dvec2 place = uv * dvec2(image.width, image.height) - 0.5;
    const dvec2 corner = glm::floor(place);
    const dvec2 fraction = place - corner;
    dvec3 colour(0.0);
    for (int i = 0; i < 4; ++i) {
        const int right = i & 1, below = i >> 1;
        const size_t x = wrapped(corner.x + right, image.width, texture.wrapU);
        const size_t y = wrapped(corner.y + below, image.height, texture.wrapV);
        const uint8_t* texel = &image.rgba[4 * (y * image.width + x)];
        const double weight = (right ? fraction.x : 1.0 - fraction.x) * (below ? fraction.y : 1.0 - fraction.y);
        colour += weight * dvec3(world.linear[texel[0]], world.linear[texel[1]], world.linear[texel[2]]);
    }
    return colour;
}

namespace {

/// Without texture or vertex colours; the point is brought onto the sphere.
SurfacePoint pointOnSphere(const World& world, const Ray& ray, const Hit& hit) {
    const Sphere& sphere = world.geometry.sphere(hit.primitive);
    const dvec3 centre(sphere.centre);
    SurfacePoint p{};
    p.surface = &world.surfaces[world.geometry.materials[hit.primitive]];
    p.medium = world.media[world.geometry.materials[hit.primitive]];
    p.faceNormal = glm::normalize(ray.origin + hit.t * ray.direction - centre);
    p.position = centre + double{sphere.radius} * p.faceNormal;
    p.front = glm::dot(ray.direction, p.faceNormal) < 0.0;
    p.normal = p.shadingNormal = p.front ? p.faceNormal : -p.faceNormal;
    p.magnitude = std::max(largest(centre), largest(centre - ray.origin)) + sphere.radius;
    p.tint = dvec3(1.0);
    return p;
}

}  // namespace

SurfacePoint surfaceAt(const World& world, const Ray& ray, const Hit& hit) {
    const Geometry& geometry = world.geometry;
    if (geometry.isSphere(hit.primitive)) return pointOnSphere(world, ray, hit);
    const Corners corners = cornersOf(geometry, hit.primitive);
    const dvec3 weights(1.0 - hit.u - hit.v, hit.u, hit.v);
    const uint32_t material = geometry.materials[hit.primitive];

    SurfacePoint p{};
    p.surface = &world.surfaces[material];
    p.medium = world.media[material];
    p.position = weights.x * corners.a + weights.y * corners.b + weights.z * corners.c;
    p.faceNormal = glm::normalize(glm::cross(corners.b - corners.a, corners.c - corners.a));
    p.front = glm::dot(ray.direction, p.faceNormal) < 0.0;
    p.normal = p.front ? p.faceNormal : -p.faceNormal;
    p.shadingNormal = interpolatedNormal(geometry, corners.index, weights, p.normal);
    if (glm::dot(p.shadingNormal, p.normal) < 0.0) p.shadingNormal = -p.shadingNormal;
    if (glm::dot(p.shadingNormal, ray.direction) >= 0.0) p.shadingNormal = p.normal;
    for (const dvec3& corner : {corners.a, corners.b, corners.c})
        p.magnitude = std::max({p.magnitude, largest(corner), largest(corner - ray.origin)});

    p.tint = dvec3(1.0);
    const auto& texture = world.scene.materials[material].baseColorTexture;
    if (texture && !geometry.uvs.empty())
        p.tint *= textureColour(world, *texture, blend(geometry.uvs, corners.index, weights));
    if (!geometry.colors.empty()) p.tint *= blend(geometry.colors, corners.index, weights);
    return p;
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
    const dvec3 emission = world.surfaces[world.geometry.materials[result.triangle]].emission;
    result.irradiance = emission * (cosines / squared / (chance / emitters.areas[i]));
    return result;
}

}  // namespace raig::reference

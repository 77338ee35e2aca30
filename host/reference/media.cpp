#include "reference/media.hpp"

#include "reference/sphere.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

namespace raig::reference {

namespace {

using Point = std::array<double, 3>;

Point pointOf(const vec3& p) {
    return {p.x == 0.0f ? 0.0 : p.x, p.y == 0.0f ? 0.0 : p.y, p.z == 0.0f ? 0.0 : p.z};
}

/// The surface that one instance has of a medium, on its way to being found closed.
struct Shell {
    std::map<std::pair<Point, Point>, int> uses;  ///< of directed edges
    std::optional<dvec3> apex;                    ///< a corner: from elsewhere little of a small volume would be left
    double volume = 0.0;                          ///< six times that of its tetrahedra
    bool isSound = true;

    void add(const vec3& a, const vec3& b, const vec3& c) {
        const Point p[3] = {pointOf(a), pointOf(b), pointOf(c)};
        for (const Point& one : p)
            for (const double x : one) isSound = isSound && std::isfinite(x);
        if (!isSound || p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) return;
        for (int i = 0; i < 3; ++i) ++uses[{p[i], p[(i + 1) % 3]}];
        if (!apex) apex = dvec3(a);
        volume += glm::dot(dvec3(a) - *apex, glm::cross(dvec3(b) - *apex, dvec3(c) - *apex));
    }
    bool isClosed() const {
        return isSound && volume > 0.0 && std::ranges::all_of(uses, [&](const auto& use) {
                   const auto opposite = uses.find({use.first.second, use.first.first});
                   return use.second == 1 && opposite != uses.end() && opposite->second == 1;
               });
    }
};

/// Of materials, the first that holds the same; noMedium for those that hold nothing.
std::vector<uint32_t> mediaOf(const std::vector<Surface>& surfaces) {
    std::map<std::tuple<float, float, float, float>, uint32_t> first;
    std::vector<uint32_t> result;
    for (uint32_t i = 0; i < surfaces.size(); ++i) {
        const Surface& s = surfaces[i];
        const bool holds = !s.thin && (s.transmission.x > 0.0f || s.transmission.y > 0.0f || s.transmission.z > 0.0f);
        const auto key = std::tuple(s.ior, s.absorption.x, s.absorption.y, s.absorption.z);
        result.push_back(holds ? first.try_emplace(key, i).first->second : noMedium);
    }
    return result;
}

}  // namespace

std::vector<uint32_t> closedMedia(const Geometry& geometry, const std::vector<Surface>& surfaces) {
    std::vector<uint32_t> media = mediaOf(surfaces);
    std::vector<uint8_t> isClosed(surfaces.size(), 1);
    for (size_t instance = 0; instance + 1 < geometry.firstTriangle.size(); ++instance) {
        std::map<uint32_t, Shell> shells;
        for (uint32_t id = geometry.firstTriangle[instance]; id < geometry.firstTriangle[instance + 1]; ++id) {
            const uint32_t medium = media[geometry.materials[id]];
            if (medium == noMedium) continue;
            const uvec3 t = geometry.triangles[id];
            if (geometry.isSphere(id))
                shells[medium].volume += geometry.sphere(id).radius;
            else
                shells[medium].add(geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]);
        }
        for (const auto& [medium, shell] : shells)
            if (!shell.isClosed()) isClosed[medium] = 0;
    }
    for (uint32_t& medium : media)
        if (medium != noMedium && isClosed[medium] == 0) medium = noMedium;
    return media;
}

void Nest::enter(uint32_t medium) {
    if (media_.size() == 4) media_.erase(media_.begin());
    media_.push_back(medium);
}

bool Nest::leave(uint32_t medium) {
    const auto last = std::find(media_.rbegin(), media_.rend(), medium);
    if (last == media_.rend()) return false;
    media_.erase(std::next(last).base());
    return true;
}

namespace {

struct Passage {
    double t;
    uint32_t id;
    uint32_t medium;
    bool isOut;
};

/// Where a ray passes surfaces of media, the farthest first.
std::vector<Passage> passages(const Geometry& geometry, const std::vector<uint32_t>& ofMaterial, const Ray& ray) {
    std::vector<Passage> found;
    for (uint32_t id = 0; id < geometry.triangles.size(); ++id) {
        const uint32_t medium = ofMaterial[geometry.materials[id]];
        if (medium == noMedium) continue;
        if (geometry.isSphere(id)) {
            const Sphere& sphere = geometry.sphere(id);
            if (!isUsableSphere(sphere.centre, sphere.radius)) continue;
            const auto both = crossSphere(ray, sphere.centre, sphere.radius);
            if (both && both->near > 0.0) found.push_back({both->near, id, medium, false});
            if (both && both->far > 0.0) found.push_back({both->far, id, medium, true});
            continue;
        }
        const uvec3 t = geometry.triangles[id];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (!raig::isUsable(a, b, c)) continue;
        const auto crossing = cross(ray, a, b, c);
        if (!crossing || crossing->t <= 0.0) continue;
        const dvec3 normal = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        found.push_back({crossing->t, id, medium, glm::dot(ray.direction, normal) > 0.0});
    }
    std::ranges::sort(found, [](const Passage& x, const Passage& y) { return std::tie(y.t, y.id) < std::tie(x.t, x.id); });
    return found;
}

}  // namespace

Nest mediaAround(const Geometry& geometry, const std::vector<uint32_t>& ofMaterial, const dvec3& point) {
    if (std::ranges::all_of(ofMaterial, [](uint32_t medium) { return medium == noMedium; })) return {};
    constexpr dvec3 directions[] = {{0.12903, 0.90311, -0.40955},
                                    {-0.77177, 0.31713, 0.55119},
                                    {0.63301, -0.52717, 0.56689},
                                    {-0.21713, -0.83117, -0.51189},
                                    {0.48119, 0.10987, 0.86973}};
    std::vector<Nest> nests;
    for (const dvec3& direction : directions) {
        Nest& nest = nests.emplace_back();
        for (const Passage& passage : passages(geometry, ofMaterial, {point, direction}))
            if (passage.isOut)
                nest.enter(passage.medium);  // seen from afar
            else
                nest.leave(passage.medium);
    }
    return *std::ranges::max_element(nests, {}, [&](const Nest& nest) { return std::ranges::count(nests, nest); });
}

}  // namespace raig::reference

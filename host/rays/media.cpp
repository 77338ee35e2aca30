#include "rays/media.hpp"

#include "base/parallel.hpp"
#include "scene/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace raig {

namespace {

bool isVolume(const Surface& surface) {
    return !surface.thin && glm::any(glm::greaterThan(surface.transmission, vec3(0.0f)));
}

/// Numbers the media; those beyond 255 get none.
void numberMedia(const Scene& scene, Media& media) {
    std::map<std::tuple<float, float, float, float>, uint8_t> known;
    for (const Material& material : scene.materials) {
        const Surface s = surfaceOf(material);
        media.ofMaterial.push_back(0);
        if (!isVolume(s)) continue;
        const auto [entry, isNew] = known.try_emplace({s.ior, s.absorption.x, s.absorption.y, s.absorption.z}, 0);
        if (isNew && media.media.size() < 256) {
            entry->second = static_cast<uint8_t>(media.media.size());
            media.media.push_back({s.absorption, s.ior});
        }
        media.ofMaterial.back() = entry->second;
    }
}

uint32_t mediumOf(const Media& media, const Geometry& geometry, const Geometry::Place& place) {
    return media.ofMaterial[geometry.materials[geometry.storedTriangle(place)]];
}

const Sphere& sphereAt(const Geometry& geometry, const Geometry::Place& place) {
    const uint32_t first = geometry.isInstanced() ? geometry.placed[place.instance].firstSphere : 0;
    return geometry.spheres[first + geometry.triangles[geometry.storedTriangle(place)].x];
}

uint32_t primitivesOf(const Geometry& geometry, uint32_t instance) {
    return geometry.firstTriangle[instance + 1] - geometry.firstTriangle[instance];
}

using Boxes = std::map<uint32_t, Box>;  // by medium

void growBySphere(const Sphere& sphere, Box& box) {
    if (isUsableSphere(sphere.centre, sphere.radius)) box.grow(sphereBox(sphere.centre, sphere.radius));
}

/// Of `count` stored triangles and spheres from `first` on; of spheres only where they are in the world already.
Boxes boxesOf(const Media& media, const Geometry& geometry, size_t first, size_t count) {
    Boxes boxes;
    Box* box = nullptr;
    uint32_t last = 0;
    for (size_t i = first; i < first + count; ++i) {
        const uint32_t medium = media.ofMaterial[geometry.materials[i]];
        if (box == nullptr || medium != last) box = &boxes[medium];
        last = medium;
        const uvec3 t = geometry.triangles[i];
        if (t.y != Geometry::noVertex) {
            const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
            if (!isUsable(a, b, c)) continue;
            for (const vec3& corner : {a, b, c}) box->grow(corner);
        } else if (!geometry.isInstanced()) {
            growBySphere(geometry.spheres[t.x], *box);
        }
    }
    return boxes;
}

/// Where an instance puts a box of its mesh.
Box placed(const Box& box, const Placement& placement) {
    Box result;
    for (unsigned corner = 0; corner < 8 && !box.empty(); ++corner)
        result.grow(placePoint(placement, glm::mix(box.lo, box.hi, glm::bvec3(corner & 1, corner & 2, corner & 4))));
    return result;
}

/// The boxes of an instance that is kept, from those of its mesh, and from its spheres.
Boxes placedBoxes(const Media& media, const Geometry& geometry, uint32_t instance, const Boxes& ofMesh) {
    const Geometry::Placed& place = geometry.placed[instance];
    const Geometry::Stored& stored = geometry.stored[place.mesh];
    Boxes boxes;
    for (const auto& [medium, box] : ofMesh) boxes[medium] = placed(box, place.placement);
    const uint32_t primitives = primitivesOf(geometry, instance);
    for (uint32_t i = primitives - stored.spheres; i < primitives; ++i) {
        const Geometry::Place sphere{instance, i};
        growBySphere(sphereAt(geometry, sphere), boxes[mediumOf(media, geometry, sphere)]);
    }
    return boxes;
}

std::vector<Media::Volume> findVolumes(const Media& media, const Geometry& geometry) {
    std::vector<Boxes> ofMesh(geometry.stored.size());
    parallelFor(ofMesh.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Geometry::Stored& stored = geometry.stored[i];
            ofMesh[i] = boxesOf(media, geometry, stored.firstTriangle, stored.triangles);
        }
    });
    std::vector<Boxes> ofInstance(geometry.firstTriangle.empty() ? 0 : geometry.firstTriangle.size() - 1);
    parallelFor(ofInstance.size(), 16, [&](size_t begin, size_t end) {
        for (size_t k = begin; k < end; ++k) {
            const auto instance = static_cast<uint32_t>(k);
            ofInstance[k] = geometry.isInstanced()
                                ? placedBoxes(media, geometry, instance, ofMesh[geometry.placed[k].mesh])
                                : boxesOf(media, geometry, geometry.firstTriangle[k], primitivesOf(geometry, instance));
        }
    });
    std::vector<Media::Volume> volumes;
    for (uint32_t k = 0; k < ofInstance.size(); ++k)
        for (const auto& [medium, box] : ofInstance[k])
            if (!box.empty()) volumes.push_back({k, medium, box});
    return volumes;
}

bool meet(const Box& a, const Box& b) {
    return glm::all(glm::lessThanEqual(a.lo, b.hi)) && glm::all(glm::lessThanEqual(b.lo, a.hi));
}

bool matters(const Media& media, const Media::Volume& a, const Media::Volume& b) {
    const auto absorbs = [&](uint32_t medium) {
        return glm::any(glm::greaterThan(media.media[medium].absorption, vec3(0.0f)));
    };
    return (a.medium != 0 && b.medium != 0) || absorbs(a.medium) || absorbs(b.medium);
}

/// Sweeps over the boxes' lower x. Too many pairs to look at count as one that matters: then rays remember what they need
/// not.
bool anyNests(const Media& media, std::vector<Media::Volume> volumes) {
    std::ranges::sort(volumes, {}, [](const Media::Volume& v) { return v.box.lo.x; });
    uint64_t pairs = 0;
    for (size_t i = 0; i < volumes.size(); ++i)
        for (size_t j = i + 1; j < volumes.size() && volumes[j].box.lo.x <= volumes[i].box.hi.x; ++j) {
            if (++pairs > uint64_t{1} << 27) return true;
            if (matters(media, volumes[i], volumes[j]) && meet(volumes[i].box, volumes[j].box)) return true;
        }
    return false;
}

using Place = std::array<float, 3>;

/// Of the triangles of one medium in one instance.
bool isClosed(const Media& media, const Geometry& geometry, const Media::Volume& volume) {
    std::vector<std::array<Place, 2>> edges;
    double six = 0.0;  // times the volume
    const dvec3 middle = 0.5 * (dvec3(volume.box.lo) + dvec3(volume.box.hi));
    for (uint32_t i = 0; i < primitivesOf(geometry, volume.instance); ++i) {
        const Geometry::Place place{volume.instance, i};
        if (mediumOf(media, geometry, place) != volume.medium) continue;
        if (geometry.isSphere(place)) {
            six += sphereAt(geometry, place).radius;  // that it is positive is all that counts
            continue;
        }
        const auto [a, b, c] = geometry.corners(place);
        if (!isFinite(a) || !isFinite(b) || !isFinite(c)) return false;
        if (a == b || b == c || c == a) continue;
        six += glm::dot(dvec3(a) - middle, glm::cross(dvec3(b) - middle, dvec3(c) - middle));
        const auto at = [](const vec3& p) { return Place{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; };  // -0 is 0
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
            edges.push_back({at(from), at(to)});
    }
    std::ranges::sort(edges);
    if (std::ranges::adjacent_find(edges) != edges.end()) return false;
    const auto isMatched = [&](const std::array<Place, 2>& edge) {
        return std::ranges::binary_search(edges, std::array{edge[1], edge[0]});
    };
    return six > 0.0 && std::ranges::all_of(edges, isMatched);
}

/// Forgets the media with a surface that is not closed.
void keepClosed(const Geometry& geometry, Media& media) {
    std::vector<uint8_t> isOpen(media.media.size(), 0);
    std::vector<uint8_t> closed(media.volumes.size(), 1);
    parallelFor(closed.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) closed[i] = isClosed(media, geometry, media.volumes[i]);
    });
    for (size_t i = 0; i < closed.size(); ++i)
        if (closed[i] == 0) isOpen[media.volumes[i].medium] = 1;
    for (uint8_t& medium : media.ofMaterial)
        if (isOpen[medium] != 0) medium = 0;
    std::erase_if(media.volumes, [&](const Media::Volume& volume) { return isOpen[volume.medium] != 0; });
}

}  // namespace

Media findMedia(const Scene& scene, const Geometry& geometry) {
    Media media;
    numberMedia(scene, media);
    if (media.media.size() == 1) return media;
    std::vector<Media::Volume> volumes = findVolumes(media, geometry);
    if (!anyNests(media, volumes)) return media;
    media.volumes = volumes;
    std::erase_if(media.volumes, [](const Media::Volume& volume) { return volume.medium == 0; });
    keepClosed(geometry, media);
    for (size_t i = 0; i < scene.materials.size(); ++i)
        media.openMaterials += media.ofMaterial[i] == 0 && isVolume(surfaceOf(scene.materials[i]));
    media.nests = !media.volumes.empty();
    return media;
}

namespace {

double distanceToSegment(const dvec3& p, const dvec3& a, const dvec3& b) {
    const dvec3 ab = b - a;
    const double along = glm::dot(ab, ab) > 0.0 ? std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0) : 0.0;
    return glm::length(p - a - along * ab);
}

double distanceTo(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 n = glm::cross(b - a, c - a);
    const auto inside = [&](const dvec3& from, const dvec3& to) {
        return glm::dot(glm::cross(to - from, p - from), n) >= 0.0;
    };
    if (glm::dot(n, n) > 0.0 && inside(a, b) && inside(b, c) && inside(c, a))
        return std::abs(glm::dot(p - a, n)) / glm::length(n);
    return std::min({distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
}

/// The solid angle of a triangle, positive where its back is seen.
double solidAngle(const dvec3& a, const dvec3& b, const dvec3& c) {
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    return 2.0 * std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

/// How often a volume's surface winds around a point, and how near it comes.
struct Around {
    double windings = 0.0;
    double distance = std::numeric_limits<double>::infinity();
};

Around aroundPoint(const Media& media, const Geometry& geometry, const Media::Volume& volume, const dvec3& point) {
    Around around;
    for (uint32_t i = 0; i < primitivesOf(geometry, volume.instance); ++i) {
        const Geometry::Place place{volume.instance, i};
        if (mediumOf(media, geometry, place) != volume.medium) continue;
        if (geometry.isSphere(place)) {
            const Sphere& sphere = sphereAt(geometry, place);
            const double depth = double{sphere.radius} - glm::length(point - dvec3(sphere.centre));
            around.windings += depth > 0.0 ? 1.0 : 0.0;
            around.distance = std::min(around.distance, std::abs(depth));
            continue;
        }
        const auto [a, b, c] = geometry.corners(place);
        around.windings += solidAngle(dvec3(a) - point, dvec3(b) - point, dvec3(c) - point) / (4.0 * std::numbers::pi);
        around.distance = std::min(around.distance, distanceTo(point, a, b, c));
    }
    return around;
}

}  // namespace

uint32_t mediaAround(const Media& media, const Geometry& geometry, const vec3& point) {
    std::vector<std::pair<double, uint32_t>> found;  // how near the surface is, and the medium
    for (const Media::Volume& volume : media.volumes) {
        if (!volume.box.contains(Box{point, point})) continue;
        const Around around = aroundPoint(media, geometry, volume, dvec3(point));
        if (around.distance == 0.0) continue;
        for (long n = std::lround(around.windings); n > 0; --n) found.emplace_back(around.distance, volume.medium);
    }
    std::ranges::stable_sort(found, std::greater{}, [](const auto& one) { return one.first; });
    uint32_t packed = 0;
    for (const auto& [distance, medium] : found) packed = packed << 8 | medium;
    return packed;
}

}  // namespace raig

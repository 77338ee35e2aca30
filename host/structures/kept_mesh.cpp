#include "structures/kept_mesh.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/instance_record.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace raig {

namespace {

/// Whether placing a vertex takes the same roundings in the structure's units of length as in the scene's, and on devices
/// that take numbers below the normal ones for zero: whether all it comes past is zero, or well within the range of floats.
class ScaleCheck {
public:
    ScaleCheck(float bottomUnit, float sceneUnit)
        : leastVertex_(std::max(0x1p-126f, 0x1p-126f / bottomUnit)), least_(std::max(0x1p-126f, 0x1p-126f / sceneUnit)),
          most_(std::min(0x1p120f, 0x1p120f / sceneUnit)) {}

    bool passes(const shared::Placement& m, const vec3& v) const {
        for (int k = 0; k < 3; ++k)
            if (v[k] != 0.0f && !(std::abs(v[k]) >= leastVertex_)) return false;
        return rowPasses(m.x, v) && rowPasses(m.y, v) && rowPasses(m.z, v);
    }

private:
    bool isSound(float x) const { return x == 0.0f || (std::abs(x) >= least_ && std::abs(x) <= most_); }
    bool rowPasses(const vec4& row, const vec3& v) const {
        float products[3];
        for (int k = 0; k < 3; ++k) {
            products[k] = row[k] * v[k];
            if (!isSound(products[k]) || (products[k] == 0.0f && row[k] != 0.0f && v[k] != 0.0f)) return false;
        }
        const float first = products[0] + products[1], second = first + products[2];
        return isSound(first) && isSound(second) && isSound(second + row.w);
    }

    float leastVertex_, least_, most_;
};

Box boundsOf(const PlacedScene& scene, const StoredMesh& mesh, const std::vector<uint8_t>& included) {
    Box bounds;
    for (size_t i = 0; i < included.size(); ++i) {
        if (included[i] == 0) continue;
        const uvec3 t = mesh.triangles[i];
        for (int k = 0; k < 3; ++k) bounds.grow(scene.positions[t[k]]);
    }
    return bounds;
}

/// The vertices of the mesh that its included triangles have.
std::vector<uint8_t> namedVertices(const StoredMesh& mesh, const std::vector<uint8_t>& included) {
    std::vector<uint8_t> named(mesh.vertices, 0);
    for (size_t i = 0; i < included.size(); ++i)
        if (included[i] != 0)
            for (int k = 0; k < 3; ++k) named[mesh.triangles[i][k] - mesh.firstVertex] = 1;
    return named;
}

/// A mesh being looked at, place by place.
class Inspection {
public:
    Inspection(const PlacedScene& scene, const StoredMesh& mesh, std::vector<uint8_t>& included, const ScaleCheck& check)
        : scene_(scene), mesh_(mesh), included_(included), check_(check), named_(namedVertices(mesh, included)),
          odd_(mesh.vertices, 0), places_(mesh.vertices) {}

    /// Excludes the triangles that are not usable where `placement` puts them.
    void look(const shared::Placement& placement) {
        parallelFor(mesh_.vertices, 16384, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                if (named_[i] == 0) continue;
                const vec3& vertex = scene_.positions[mesh_.firstVertex + i];
                if (!check_.passes(placement, vertex)) odd_[i] = 1;
                places_[i] = shared::placePoint(placement, vertex);
            }
        });
        forTriangles([&](const uvec3& t) { return isUsable(places_[t.x], places_[t.y], places_[t.z]); });
    }

    /// Excludes triangles with a vertex that the check did not pass in some place: the last exclusion.
    void excludeOdd() {
        if (std::find(odd_.begin(), odd_.end(), 1) != odd_.end())
            forTriangles([&](const uvec3& t) { return odd_[t.x] + odd_[t.y] + odd_[t.z] == 0; });
        named_ = namedVertices(mesh_, included_);
    }

    /// The box of the included triangles where `placement` puts them. Requires that nothing be excluded any more: a vertex
    /// of an excluded one may be anywhere, or be no number.
    Box boxOf(const shared::Placement& placement) const {
        Box box;
        std::mutex mutex;
        parallelFor(mesh_.vertices, 16384, [&](size_t begin, size_t end) {
            Box part;
            for (size_t i = begin; i < end; ++i)
                if (named_[i] != 0) part.grow(shared::placePoint(placement, scene_.positions[mesh_.firstVertex + i]));
            const std::lock_guard lock(mutex);
            box.grow(part);
        });
        return box;
    }

private:
    /// Leaves of the included triangles those for which `holds`, told the vertices' indices in the mesh.
    template <class Holds>
    void forTriangles(const Holds& holds) {
        parallelFor(included_.size(), 16384, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                if (included_[i] != 0 && !holds(mesh_.triangles[i] - mesh_.firstVertex)) included_[i] = 0;
        });
    }

    const PlacedScene& scene_;
    const StoredMesh& mesh_;
    std::vector<uint8_t>& included_;
    ScaleCheck check_;
    std::vector<uint8_t> named_, odd_;
    std::vector<vec3> places_;
};

}  // namespace

Triangle writtenOut(const PlacedScene& scene, const PlacedMesh& placed, uint32_t triangle) {
    const uvec3 t = scene.meshes[placed.mesh].triangles[triangle];
    const vec3 a = shared::placePoint(placed.placement, scene.positions[t.x]);
    const vec3 b = shared::placePoint(placed.placement, scene.positions[t.y]);
    const vec3 c = shared::placePoint(placed.placement, scene.positions[t.z]);
    return placed.mirrored ? Triangle{a, c, b} : Triangle{a, b, c};
}

KeptMesh keepMesh(const PlacedScene& scene, uint32_t index, std::span<const uint32_t> instances, float sceneUnit) {
    const StoredMesh& mesh = scene.meshes[index];
    KeptMesh kept;
    if (!mesh.keeps || instances.size() < 2) return kept;
    kept.included.resize(mesh.triangles.size());
    parallelFor(mesh.triangles.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = mesh.triangles[i];
            kept.included[i] = isUsable(scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]);
        }
    });
    const Box bounds = boundsOf(scene, mesh, kept.included);
    const float unit = unitOf(bounds);
    const Box inUnit{bounds.lo * unit, bounds.hi * unit};
    const vec3 size = scene.bounds.extent() * sceneUnit;
    for (const uint32_t instance : instances) {
        const shared::Placement& placement = scene.instances[instance].placement;
        const shared::Placement inner = betweenUnits(placement, unit, sceneUnit);
        if (isExact(placement, inner, unit, sceneUnit) && fits(inner, inUnit, std::max({size.x, size.y, size.z})))
            kept.instances.push_back({instance, inner, {}});
    }
    if (kept.instances.size() < 2) return {};

    Inspection inspection(scene, mesh, kept.included, ScaleCheck(unit, sceneUnit));
    for (const KeptInstance& instance : kept.instances) inspection.look(scene.instances[instance.instance].placement);
    inspection.excludeOdd();
    kept.bounds = boundsOf(scene, mesh, kept.included);
    // With another unit of length, what was checked would be another matter. It hardly ever happens.
    if (kept.bounds.empty() || unitOf(kept.bounds) != unit) return {};
    for (KeptInstance& instance : kept.instances) {
        instance.box = inspection.boxOf(scene.instances[instance.instance].placement);
        RAIG_CHECK(scene.bounds.contains(instance.box) && !instance.box.empty());
    }
    return kept;
}

}  // namespace raig

#include "measure/trace_place.hpp"

#include "measure/compare_rays.hpp"
#include "rays/primitives.hpp"

#include <algorithm>
#include <array>

namespace raig {

namespace {

/// The box that pictures frame.
Box subjectOf(const std::vector<Primitive>& primitives, const Box& bounds) {
    std::array<std::vector<float>, 3> centres;
    for (const Primitive& p : primitives)
        if (p.usable())
            for (int axis = 0; axis < 3; ++axis) centres[axis].push_back(0.5f * (p.box().lo[axis] + p.box().hi[axis]));
    if (centres[0].size() < 100) return bounds;
    vec3 lo(0.0f), hi(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        std::sort(centres[axis].begin(), centres[axis].end());
        const size_t out = centres[axis].size() / 100;
        lo[axis] = centres[axis][out];
        hi[axis] = centres[axis][centres[axis].size() - 1 - out];
    }
    constexpr float uneven = 8.0f;  // the whole is so much longer
    const vec3 size = hi - lo, whole = bounds.extent();
    if (std::max({whole.x, whole.y, whole.z}) < uneven * std::max({size.x, size.y, size.z})) return bounds;
    return {lo - 0.125f * size, hi + 0.125f * size};
}

}  // namespace

TracePlace::TracePlace(const ChartScene& scene, double offset)
    : scene_(&scene), offset_(offset), geometry_(scene.geometry()) {
    if (offset != 0.0) {
        for (vec3& p : geometry_.positions) p = vec3(dvec3(p) + offset);
        for (Sphere& s : geometry_.spheres) s.centre = vec3(dvec3(s.centre) + offset);
        geometry_.bounds = {};
        primitives_ = primitivesOf(geometry_);
        for (const Primitive& p : primitives_)
            if (p.usable()) geometry_.bounds.grow(p.box());
    }
    const Structure structure = structureType("bvh").build(primitives(), {});
    const std::unique_ptr<Tracer> tracer = makeCpuTracer(structure);
    const Box framed = subjectOf(primitives(), geometry_.bounds);
    const MeasuringCamera camera = measuringCamera(geometry_, framed);
    sets_ = makeRaySets(geometry_, framed, camera, side, *tracer);
    // The same rays at any offset, to rounding: aimed at where corners have come to lie.
    aimed_ = aimedRays(geometry_, vec3(camera.eye), judgedRays);
    aimedHits_.resize(aimed_.size());
    tracer->trace(aimed_, aimedHits_, Query::closest);
    primaryHits_.resize(sets_.primary.size());
    tracer->trace(sets_.primary, primaryHits_, Query::closest);
}

const std::vector<Ray>& TracePlace::rays(const std::string& name) const {
    if (name == "primary") return sets_.primary;
    if (name == "shadow") return sets_.shadow;
    if (name == "diffuse") return sets_.diffuse;
    return sets_.specular;
}

const reference::Tree& TracePlace::tree() {
    if (!tree_) tree_ = std::make_unique<reference::Tree>(geometry_);
    return *tree_;
}

}  // namespace raig

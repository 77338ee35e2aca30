#include "structures/two_level_plan.hpp"

#include "base/parallel.hpp"

#include <limits>

namespace raig {

namespace {

/// Of the triangles of a mesh, those that its bottom lacks.
std::vector<uint32_t> excludedOf(const KeptMesh& kept) {
    std::vector<uint32_t> excluded;
    for (uint32_t i = 0; i < kept.included.size(); ++i)
        if (kept.included[i] == 0) excluded.push_back(i);
    return excluded;
}

WrittenOut writeOut(const PlacedScene& scene, const std::vector<KeptMesh>& kept) {
    std::vector<uint8_t> isKept(scene.instances.size(), 0);
    std::vector<std::vector<uint32_t>> excluded(scene.meshes.size());
    for (size_t i = 0; i < kept.size(); ++i) {
        for (const KeptInstance& instance : kept[i].instances) isKept[instance.instance] = 1;
        if (!kept[i].instances.empty()) excluded[i] = excludedOf(kept[i]);
    }
    WrittenOut out;
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const PlacedMesh& placed = scene.instances[i];
        const auto add = [&](uint32_t index) {
            const Triangle triangle = writtenOut(scene, placed, index);
            if (!triangle.usable()) return;
            out.primitives.push_back(triangle);
            out.ids.push_back(placed.firstId + index);
        };
        if (isKept[i] != 0) {
            for (const uint32_t index : excluded[placed.mesh]) add(index);
        } else {
            for (uint32_t index = 0; index < scene.meshes[placed.mesh].triangles.size(); ++index) add(index);
        }
    }
    for (const PlacedPrimitive& other : scene.others) {
        if (!other.primitive.usable()) continue;
        out.primitives.push_back(other.primitive);
        out.ids.push_back(other.id);
    }
    return out;
}

/// True if what is written out is so small a part of the scene that its unit is out of the scene's reach.
bool isOutOfScale(const WrittenOut& out, float sceneUnit) {
    Box bounds;
    for (const Primitive& primitive : out.primitives) bounds.grow(primitive.box());
    return !bounds.empty() && unitOf(bounds) > 0x1p60f * sceneUnit;
}

}  // namespace

uint64_t TwoLevelPlan::instanceCount() const {
    uint64_t count = out.primitives.empty() ? 0 : 1;
    for (const KeptMesh& mesh : kept) count += mesh.instances.size();
    return count;
}

TwoLevelPlan planTwoLevels(const PlacedScene& scene) {
    TwoLevelPlan plan;
    plan.unit = unitOf(scene.bounds);
    std::vector<std::vector<uint32_t>> instancesOf(scene.meshes.size());
    for (uint32_t i = 0; i < scene.instances.size(); ++i) instancesOf[scene.instances[i].mesh].push_back(i);
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) plan.kept.push_back(keepMesh(scene, i, instancesOf[i], plan.unit));
    plan.out = writeOut(scene, plan.kept);
    if (isOutOfScale(plan.out, plan.unit)) {
        plan.kept.assign(plan.kept.size(), {});
        plan.out = writeOut(scene, plan.kept);
    }
    if (!plan.out.primitives.empty()) plan.meshes.push_back(Bottom::writtenOut);
    for (uint32_t i = 0; i < plan.kept.size(); ++i)
        if (!plan.kept[i].instances.empty()) plan.meshes.push_back(i);
    return plan;
}

std::span<const Primitive> primitivesUnder(const PlacedScene& scene, const TwoLevelPlan& plan, uint32_t mesh,
                                           std::vector<Primitive>& storage) {
    if (mesh == Bottom::writtenOut) return plan.out.primitives;
    const vec3 none(std::numeric_limits<float>::quiet_NaN());
    const std::span<const uvec3> triangles = scene.meshes[mesh].triangles;
    const std::vector<uint8_t>& included = plan.kept[mesh].included;
    storage.resize(triangles.size());
    parallelFor(triangles.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = triangles[i];
            storage[i] = included[i] != 0 ? Triangle{scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]}
                                          : Triangle{none, none, none};
        }
    });
    return storage;
}

}  // namespace raig

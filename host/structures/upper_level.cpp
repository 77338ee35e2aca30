#include "structures/upper_level.hpp"

#include "base/error.hpp"
#include "structures/instance_record.hpp"
#include "structures/top_tree.hpp"

#include <algorithm>

namespace raig {

namespace {

/// An instance: of which bottom, and where.
struct Placed {
    uint32_t bottom;
    uint32_t firstId;
    bool mirrored;
    shared::Placement inner;
    Box box;
};

/// In the order of their records: bottom by bottom.
std::vector<Placed> placeAll(const PlacedScene& scene, const TwoLevelPlan& plan, std::span<const BottomShape> shapes) {
    std::vector<Placed> all;
    for (uint32_t i = 0; i < shapes.size(); ++i) {
        const StructureHeader& header = shapes[i].header;
        if (plan.meshes[i] == Bottom::writtenOut) {
            const float scale = plan.unit / header.unit;
            all.push_back({i,
                           0,
                           false,
                           {vec4(scale, 0, 0, 0), vec4(0, scale, 0, 0), vec4(0, 0, scale, 0)},
                           {header.lo / header.unit, header.hi / header.unit}});
            continue;
        }
        for (const KeptInstance& kept : plan.kept[plan.meshes[i]].instances) {
            const PlacedMesh& placed = scene.instances[kept.instance];
            all.push_back({i, placed.firstId, placed.mirrored, kept.inner, kept.box});
        }
    }
    return all;
}

void writeInstances(const std::vector<Placed>& all, std::span<const BottomShape> shapes, float unit, UpperLevel& upper) {
    for (size_t i = 0; i < all.size(); ++i) {
        const Placed& placed = all[i];
        const StructureHeader& header = shapes[placed.bottom].header;
        const vec3 at = placed.box.centre() * unit;
        const InstanceSpace space = instanceSpace(placed.inner, {header.lo, header.hi}, at);
        RAIG_CHECK(space.invertible);
        const auto bottomAt = static_cast<uint32_t>(upper.places.bottoms + uint64_t{placed.bottom} * shared::BOTTOM_STRIDE);
        writeInstance(&upper.nodes[upper.places.instances + i * shared::INSTANCE_STRIDE], placed.inner, space, at,
                      placed.firstId, bottomAt, placed.mirrored);
    }
}

/// Returns how many triangles there are, in uvec4.
uint64_t writeBottoms(const TwoLevelPlan& plan, std::span<const BottomShape> shapes, UpperLevel& upper) {
    uint64_t nodesAt = upper.places.end, trianglesAt = 0;
    for (size_t i = 0; i < shapes.size(); ++i) {
        uvec4* record = &upper.nodes[upper.places.bottoms + i * shared::BOTTOM_STRIDE];
        const StructureHeader& header = shapes[i].header;
        std::copy_n(reinterpret_cast<const uvec4*>(&header), sizeof header / sizeof(uvec4), record);
        record[4] = {static_cast<uint32_t>(nodesAt), static_cast<uint32_t>(trianglesAt), 0, 0};
        upper.bottoms.push_back(
            {plan.meshes[i], trianglesAt / shared::TRIANGLE_STRIDE, shapes[i].triangles / shared::TRIANGLE_STRIDE});
        nodesAt += shapes[i].nodes;
        trianglesAt += shapes[i].triangles;
    }
    return trianglesAt;
}

}  // namespace

UpperPlaces upperPlaces(uint64_t instances, uint64_t bottoms) {
    UpperPlaces places;
    places.topTreeEnd = topTreeBytes(instances) / sizeof(uvec4);
    places.instances = (places.topTreeEnd + shared::INSTANCES_UNIT - 1) / shared::INSTANCES_UNIT * shared::INSTANCES_UNIT;
    places.bottoms = places.instances + instances * shared::INSTANCE_STRIDE;
    places.end = places.bottoms + bottoms * shared::BOTTOM_STRIDE;
    return places;
}

UpperLevel makeUpperLevel(const PlacedScene& scene, const TwoLevelPlan& plan, std::span<const BottomShape> shapes) {
    RAIG_CHECK_OP(shapes.size(), ==, plan.meshes.size());
    const std::vector<Placed> all = placeAll(scene, plan, shapes);
    std::vector<Box> boxes;
    for (const Placed& placed : all) boxes.push_back(placed.box);
    TopTree top = buildTopTree(boxes, plan.unit);

    UpperLevel upper;
    upper.places = upperPlaces(all.size(), shapes.size());
    upper.nodes = std::move(top.nodes);
    RAIG_CHECK_OP(upper.nodes.size(), ==, upper.places.topTreeEnd);
    upper.nodes.resize(upper.places.end, uvec4(0));
    const uint64_t triangles = writeBottoms(plan, shapes, upper);
    writeInstances(all, shapes, plan.unit, upper);

    upper.instances = static_cast<uint32_t>(all.size());
    upper.nodeCount = top.nodeCount;
    upper.depth = top.depth;
    upper.sahCost = top.sahCost;
    upper.visits.resize(shapes.size());
    for (size_t i = 0; i < all.size(); ++i) upper.visits[all[i].bottom] += top.visits[i];

    StructureHeader& header = upper.header;
    header = emptyHeader();
    header.unit = plan.unit;
    header.lo = scene.bounds.lo * plan.unit;
    header.hi = scene.bounds.hi * plan.unit;
    header.nodeCount = top.nodeCount;
    header.triangleCount = static_cast<uint32_t>(triangles / shared::TRIANGLE_STRIDE);
    header.walk = shapes.front().header.walk;
    header.gridOrigin = vec3(0.0f);
    header.gridStep =
        vec3(static_cast<float>(top.apart), static_cast<float>(upper.places.instances / shared::INSTANCES_UNIT), 0.0f);
    return upper;
}

}  // namespace raig

#include "structures/two_level.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/instance_record.hpp"
#include "structures/kept_mesh.hpp"
#include "structures/top_tree.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

namespace raig {

namespace {

/// What is written out: triangles in the world, and their ids.
struct WrittenOut {
    std::vector<Triangle> triangles;
    std::vector<uint32_t> ids;
};

/// A structure, and the mesh it was built over.
struct Built {
    uint32_t mesh = Bottom::writtenOut;
    Structure structure;
};

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
            out.triangles.push_back(triangle);
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
        out.triangles.push_back(other.primitive);
        out.ids.push_back(other.id);
    }
    return out;
}

/// True if what is written out is so small a part of the scene that its unit is out of the scene's reach.
bool isOutOfScale(const WrittenOut& out, float sceneUnit) {
    Box bounds;
    for (const Triangle& triangle : out.triangles) bounds.grow(triangle.box());
    return !bounds.empty() && unitOf(bounds) > 0x1p60f * sceneUnit;
}

/// The mesh's triangles, ids being indices: those that are not included are such that every builder leaves them out.
std::vector<Triangle> includedTriangles(const PlacedScene& scene, const StoredMesh& mesh, const KeptMesh& kept) {
    const vec3 none(std::numeric_limits<float>::quiet_NaN());
    std::vector<Triangle> triangles(mesh.triangles.size());
    parallelFor(triangles.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = mesh.triangles[i];
            triangles[i] = kept.included[i] != 0
                               ? Triangle{scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]}
                               : Triangle{none, none, none};
        }
    });
    return triangles;
}

/// Bytes of the top tree and of the records of instances and bottoms, at most. Throws limitError if they exceed the budget.
uint64_t topBytes(const std::vector<KeptMesh>& kept, const BuildParams& params) {
    uint64_t instances = 1, bottoms = 1;  // what is written out
    for (const KeptMesh& mesh : kept) {
        instances += mesh.instances.size();
        bottoms += mesh.instances.empty() ? 0 : 1;
    }
    if (instances == 1) return 0;
    const uint64_t records = instances * shared::INSTANCE_STRIDE + bottoms * shared::BOTTOM_STRIDE + shared::INSTANCES_UNIT;
    const uint64_t bytes = topTreeBytes(instances) + records * sizeof(uvec4);
    if (bytes > params.memoryBudget)
        throw limitError("{} instances need {} MiB and --memory-budget allows {}: raise it", instances, (bytes >> 20) + 1,
                         params.memoryBudget >> 20);
    return bytes;
}

/// All bottoms, the written out one first.
std::vector<Built> buildBottoms(const PlacedScene& scene, const std::vector<KeptMesh>& kept, const WrittenOut& out,
                                const StructureType& type, const BuildParams& params) {
    std::vector<Built> all;
    BuildParams left = params;
    left.memoryBudget -= topBytes(kept, params);
    const auto build = [&](uint32_t mesh, std::span<const Triangle> triangles) {
        all.push_back({mesh, type.build(triangles, left)});
        left.memoryBudget -= std::min(left.memoryBudget, all.back().structure.statistics.bytes);
    };
    if (!out.triangles.empty()) {
        build(Bottom::writtenOut, out.triangles);
        std::vector<uvec4>& references = all.back().structure.triangles;
        for (size_t i = 0; i < references.size(); i += shared::TRIANGLE_STRIDE) references[i].w = out.ids[references[i].w];
    }
    for (uint32_t i = 0; i < kept.size(); ++i)
        if (!kept[i].instances.empty()) build(i, includedTriangles(scene, scene.meshes[i], kept[i]));
    return all;
}

bool sameWalk(const std::vector<Built>& all) {
    return std::all_of(all.begin(), all.end(),
                       [&](const Built& b) { return b.structure.header.walk == all.front().structure.header.walk; });
}

/// Puts the parts of two levels into the arrays of one structure.
class Joiner {
public:
    Joiner(const PlacedScene& scene, const std::vector<KeptMesh>& kept, float unit)
        : scene_(scene), kept_(kept), unit_(unit) {}

    Structure join(std::vector<Built> all) {
        Structure result;
        result.name = all.front().structure.name;
        result.walk = fmt::format("instances, {}", all.front().structure.walk);
        collectInstances(all);
        TopTree top = buildTopTree(boxes_, unit_);
        layOut(top, all.size(), result);
        std::vector<double> costs;
        for (Built& built : all) {
            costs.push_back(built.structure.statistics.sahCost);
            append(std::move(built), result);
        }
        writeInstances(result);
        setHeader(top, result);
        measure(top, costs, result.statistics);
        result.statistics.bytes = (result.nodes.size() + result.triangles.size()) * sizeof(uvec4);
        return result;
    }

private:
    struct Placed {
        uint32_t bottom;
        uint32_t firstId;
        bool mirrored;
        shared::Placement inner;
    };

    void collectInstances(const std::vector<Built>& all) {
        for (uint32_t i = 0; i < all.size(); ++i) {
            const StructureHeader& header = all[i].structure.header;
            if (all[i].mesh == Bottom::writtenOut) {
                const float scale = unit_ / header.unit;
                instances_.push_back({i, 0, false, {vec4(scale, 0, 0, 0), vec4(0, scale, 0, 0), vec4(0, 0, scale, 0)}});
                boxes_.push_back({header.lo / header.unit, header.hi / header.unit});
                continue;
            }
            for (const KeptInstance& kept : kept_[all[i].mesh].instances) {
                const PlacedMesh& placed = scene_.instances[kept.instance];
                instances_.push_back({i, placed.firstId, placed.mirrored, kept.inner});
                boxes_.push_back(kept.box);
            }
        }
    }

    /// Room for the top tree, which is moved there, instances, and bottoms.
    void layOut(TopTree& top, size_t bottoms, Structure& result) {
        result.nodes = std::move(top.nodes);
        instancesAt_ = (result.nodes.size() + shared::INSTANCES_UNIT - 1) / shared::INSTANCES_UNIT * shared::INSTANCES_UNIT;
        bottomsAt_ = instancesAt_ + instances_.size() * shared::INSTANCE_STRIDE;
        result.nodes.resize(bottomsAt_ + bottoms * shared::BOTTOM_STRIDE, uvec4(0));
    }

    void append(Built built, Structure& result) {
        const Structure& bottom = built.structure;
        headers_.push_back(bottom.header);
        const size_t nodesAt = result.nodes.size(), trianglesAt = result.triangles.size();
        if (nodesAt + bottom.nodes.size() > 0xffffffffu || trianglesAt + bottom.triangles.size() > 0xffffffffu)
            throw limitError("two levels of {} need more than 2^32 elements; use fewer or simpler meshes", bottom.name);
        uvec4* record = &result.nodes[bottomsAt_ + result.bottoms.size() * shared::BOTTOM_STRIDE];
        std::copy_n(reinterpret_cast<const uvec4*>(&bottom.header), sizeof bottom.header / sizeof(uvec4), record);
        record[4] = {static_cast<uint32_t>(nodesAt), static_cast<uint32_t>(trianglesAt), 0, 0};
        result.bottoms.push_back({built.mesh, trianglesAt / shared::TRIANGLE_STRIDE,
                                  bottom.triangles.size() / shared::TRIANGLE_STRIDE});
        result.nodes.insert(result.nodes.end(), bottom.nodes.begin(), bottom.nodes.end());
        result.triangles.insert(result.triangles.end(), bottom.triangles.begin(), bottom.triangles.end());
        StructureStatistics& sum = result.statistics;
        sum.nodes += bottom.statistics.nodes;
        sum.leaves += bottom.statistics.leaves;
        sum.references += bottom.statistics.references;
        sum.depth = std::max(sum.depth, bottom.statistics.depth);
        for (const std::string& remark : bottom.remarks)
            if (std::find(result.remarks.begin(), result.remarks.end(), remark) == result.remarks.end())
                result.remarks.push_back(remark);
    }

    void writeInstances(Structure& result) const {
        for (size_t i = 0; i < instances_.size(); ++i) {
            const Placed& placed = instances_[i];
            const StructureHeader& header = headers_[placed.bottom];
            const vec3 at = boxes_[i].centre() * unit_;
            const InstanceSpace space = instanceSpace(placed.inner, {header.lo, header.hi}, at);
            RAIG_CHECK(space.invertible);
            const auto bottomAt = static_cast<uint32_t>(bottomsAt_ + placed.bottom * shared::BOTTOM_STRIDE);
            writeInstance(&result.nodes[instancesAt_ + i * shared::INSTANCE_STRIDE], placed.inner, space, at, placed.firstId,
                          bottomAt, placed.mirrored);
        }
    }

    void setHeader(const TopTree& top, Structure& result) const {
        StructureHeader& header = result.header;
        header = emptyHeader();
        header.unit = unit_;
        header.lo = scene_.bounds.lo * unit_;
        header.hi = scene_.bounds.hi * unit_;
        header.nodeCount = top.nodeCount;
        header.triangleCount = static_cast<uint32_t>(result.triangles.size() / shared::TRIANGLE_STRIDE);
        header.walk = headers_.front().walk;
        header.gridOrigin = vec3(0.0f);
        header.gridStep =
            vec3(static_cast<float>(top.apart), static_cast<float>(instancesAt_ / shared::INSTANCES_UNIT), 0.0f);
        result.instances = static_cast<uint32_t>(instances_.size());
    }

    void measure(const TopTree& top, const std::vector<double>& costs, StructureStatistics& statistics) const {
        statistics.nodes += top.nodeCount;
        statistics.depth += top.depth;
        statistics.sahCost = top.sahCost;
        for (size_t i = 0; i < instances_.size(); ++i) statistics.sahCost += top.visits[i] * costs[instances_[i].bottom];
    }

    const PlacedScene& scene_;
    const std::vector<KeptMesh>& kept_;
    float unit_;
    std::vector<Placed> instances_;
    std::vector<Box> boxes_;
    std::vector<StructureHeader> headers_;
    size_t instancesAt_ = 0, bottomsAt_ = 0;
};

}  // namespace

Structure buildTwoLevels(const PlacedScene& scene, const StructureType& type, const BuildParams& params) {
    const auto start = std::chrono::steady_clock::now();
    const float unit = unitOf(scene.bounds);
    std::vector<std::vector<uint32_t>> instancesOf(scene.meshes.size());
    for (uint32_t i = 0; i < scene.instances.size(); ++i) instancesOf[scene.instances[i].mesh].push_back(i);
    std::vector<KeptMesh> kept;
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) kept.push_back(keepMesh(scene, i, instancesOf[i], unit));
    WrittenOut out = writeOut(scene, kept);
    if (isOutOfScale(out, unit)) {
        kept.assign(kept.size(), {});
        out = writeOut(scene, kept);
    }

    std::vector<Built> all = buildBottoms(scene, kept, out, type, params);
    if (all.empty()) return type.build({}, params);
    if (all.size() == 1 && all.front().mesh == Bottom::writtenOut) return std::move(all.front().structure);
    if (!sameWalk(all)) {
        // One kernel walks them all. What they differ in is the precision that suits each, or if grids are nested: so all
        // get the higher, or are.
        BuildParams same = params;
        if (type.name == "grid")
            same.nestsGrids = true;
        else
            same.precision = 32;
        all.clear();
        all = buildBottoms(scene, kept, out, type, same);
        if (!sameWalk(all)) throw limitError("not all meshes can have the same walk within --memory-budget: raise it");
    }
    Structure result = Joiner(scene, kept, unit).join(std::move(all));
    result.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

}  // namespace raig

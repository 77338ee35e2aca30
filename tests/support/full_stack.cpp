#include "support/full_stack.hpp"

#include "structures/bvh_trail.hpp"

#include <algorithm>

namespace raig::test {

namespace {

using namespace glm;
using namespace shared;

#define COUNT_TRIANGLE(did) ++counters.triangleTests;

class FullStack {
public:
    FullStack(const Structure& structure, WalkCounters& counters)
        : structure(structure), header(structure.header), counters(counters) {}

    Hit trace(const Ray& ray) {
        const WalkRay walkRay = prepareRay(ray, header.lo, header.hi, header.unit);
        Hit best{walkRay.tMax, 0.0f, 0.0f, NO_HIT};
        if (walkRay.valid && header.triangleCount > 0) walk(walkRay, best);
        best.t = best.primitive == NO_HIT ? std::numeric_limits<float>::infinity()
                                          : distanceOutside(walkRay, header.unit, best.t);
        return best;
    }

private:
    static constexpr bool SKIP_SEE_THROUGH = false, HAS_SPHERES = true;

    struct Entry {
        uint32_t word;
        float enter;
    };

    uvec4 triangles_at(uint i) const { return structure.triangles[i]; }

#include "intersect.glsl"
#include "triangles.glsl"

    void walk(const WalkRay& ray, Hit& best) {
        std::vector<Entry> stack{{0, ray.tMin}};
        while (!stack.empty()) {
            const Entry next = stack.back();
            stack.pop_back();
            if (next.enter > best.t) continue;
            if ((next.word & bvh::leafBit) != 0) {
                const uint32_t first = (next.word & ~bvh::leafBit) >> 4;
                for (uint32_t i = first; i < first + (next.word & 15); ++i) testTriangle(ray, i, best);
                continue;
            }
            ++counters.nodeFetches;
            const bvh::TrailNode node(structure, next.word);
            std::vector<Entry> met;
            for (uint32_t slot = 0; slot < bvh::trailArity(header); ++slot) {
                if (node.word(slot) == bvh::noChild) continue;
                ++counters.boxTests;
                float enter = ray.tMin, leave = best.t;
                const bvh::TrailNode::Extent box = node.extent(slot);
                for (int axis = 0; axis < 3; ++axis) {
                    const bool down = ray.inverse[axis] < 0.0f;
                    const auto near = static_cast<float>(down ? box.hi[axis] : box.lo[axis]);
                    const auto far = static_cast<float>(down ? box.lo[axis] : box.hi[axis]);
                    enter = std::max(enter, (near - ray.origin[axis]) * ray.inverse[axis] - ray.reach[axis]);
                    leave = std::min(leave, (far - ray.origin[axis]) * ray.inverse[axis] + ray.reach[axis]);
                }
                if (enter <= leave) met.push_back({node.word(slot), enter});
            }
            std::stable_sort(met.begin(), met.end(), [](const Entry& a, const Entry& b) { return a.enter < b.enter; });
            stack.insert(stack.end(), met.rbegin(), met.rend());
        }
    }

    const Structure& structure;
    const StructureHeader& header;
    WalkCounters& counters;
};

#undef COUNT_TRIANGLE

}  // namespace

std::vector<Hit> traceWithFullStack(const Structure& structure, const std::vector<Ray>& rays, WalkCounters& counters) {
    FullStack walk(structure, counters);
    std::vector<Hit> hits;
    for (const Ray& ray : rays) hits.push_back(walk.trace(ray));
    return hits;
}

}  // namespace raig::test

#include "measure/naive_bvh.hpp"

#include "base/parallel.hpp"
#include "measure/naive.hpp"

#include <algorithm>

namespace raig::hard::naive {

namespace {

constexpr uint32_t mostInLeaf = 4, mostLevels = 60;

}  // namespace

Bvh::Bvh(std::span<const Primitive> primitives) : triangles_(primitives.begin(), primitives.end()) {
    for (uint32_t i = 0; i < triangles_.size(); ++i)
        if (!triangles_[i].isSphere() && triangles_[i].usable()) ids_.push_back(i);
    if (!ids_.empty()) build(0, static_cast<uint32_t>(ids_.size()), 0);
}

size_t Bvh::bytes() const {
    return nodes_.size() * sizeof(Node) + ids_.size() * (sizeof(uint32_t) + 3 * sizeof(vec3));
}

uint32_t Bvh::build(uint32_t begin, uint32_t end, uint32_t depth) {
    const auto at = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Box box;
    for (uint32_t i = begin; i < end; ++i) box.grow(triangles_[ids_[i]].box());
    nodes_[at] = {box, begin, end - begin};
    if (end - begin <= mostInLeaf || depth == mostLevels) return at;
    const vec3 size = box.extent();
    const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const uint32_t middle = begin + (end - begin) / 2;
    const auto centre = [&](uint32_t id) {
        return triangles_[id].a[axis] + triangles_[id].b[axis] + triangles_[id].c[axis];
    };
    std::nth_element(ids_.begin() + begin, ids_.begin() + middle, ids_.begin() + end,
                     [&](uint32_t l, uint32_t r) { return std::pair(centre(l), l) < std::pair(centre(r), r); });
    build(begin, middle, depth + 1);
    const uint32_t right = build(middle, end, depth + 1);
    nodes_[at].first = right;
    nodes_[at].count = 0;
    return at;
}

Hit Bvh::closest(const Ray& ray) const {
    Hit best{ray.tMax, 0.0f, 0.0f, NO_HIT};
    uint32_t stack[mostLevels + 2], size = 0;
    if (!nodes_.empty()) stack[size++] = 0;
    while (size > 0) {
        const uint32_t at = stack[--size];
        const Node& node = nodes_[at];
        Ray rest = ray;
        rest.tMax = best.t;
        if (!meets(Slab::glsl, node.box, rest)) continue;
        if (node.count == 0) {
            stack[size++] = node.first;
            stack[size++] = at + 1;
            continue;
        }
        for (uint32_t i = node.first; i < node.first + node.count; ++i) {
            const auto t = meets(Tester::moellerTrumbore, triangles_[ids_[i]], ray);
            if (t && *t >= ray.tMin && *t <= best.t && (*t < best.t || ids_[i] < best.primitive))
                best = {*t, 0.0f, 0.0f, ids_[i]};
        }
    }
    return best.primitive == NO_HIT ? Hit{0.0f, 0.0f, 0.0f, NO_HIT} : best;
}

void Bvh::trace(std::span<const Ray> rays, std::span<Hit> hits) const {
    parallelFor(rays.size(), 1024, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) hits[i] = closest(rays[i]);
    });
}

}  // namespace raig::hard::naive

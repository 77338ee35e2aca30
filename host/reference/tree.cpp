#include "reference/tree.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "reference/sphere.hpp"

#include <algorithm>

namespace raig::reference {

struct Tree::Item {
    vec3 centre;
    uint32_t id;
};

/// A ray on its way through the tree, and the best it has met so far.
struct Tree::Search {
    const Ray& ray;
    dvec3 inverse;
    uint32_t leaving;
    uint32_t arriving;
    bool any;  ///< the first opaque triangle will do
    std::span<const uint8_t> seeThrough;
    Hit best;

    Search(const Ray& r, uint32_t leavingId, uint32_t arrivingId, bool anyHit, std::span<const uint8_t> transparent)
        : ray(r),
          inverse(1.0 / r.direction),
          leaving(leavingId),
          arriving(arrivingId),
          any(anyHit),
          seeThrough(transparent) {
        best.t = r.tMax;
    }

    bool done() const { return any && best.primitive != noTriangle; }

    /// Where the ray enters the box, or infinity if it misses it or enters beyond the best hit. Widened by 1e-14 of each
    /// distance, which errs by 2^-51 of itself.
    double enter(const Box& box) const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        double from = ray.tMin, to = best.t;
        for (int axis = 0; axis < 3; ++axis) {
            const double o = ray.origin[axis], lo = box.lo[axis], hi = box.hi[axis];
            if (ray.direction[axis] == 0.0) {
                if (o < lo || o > hi) return infinity;
                continue;
            }
            double near = (lo - o) * inverse[axis], far = (hi - o) * inverse[axis];
            if (inverse[axis] < 0.0) std::swap(near, far);
            from = std::max(from, near - 1e-14 * std::abs(near));
            to = std::min(to, far + 1e-14 * std::abs(far));
        }
        return from <= to ? from : infinity;
    }
};

Tree::Tree(const Geometry& geometry) : geometry_(&geometry) {
    RAIG_CHECK_OP(geometry.triangles.size(), <, size_t{noTriangle});
    std::vector<Item> items;
    items.reserve(geometry.triangles.size());
    for (uint32_t id = 0; id < geometry.triangles.size(); ++id) {
        if (geometry.isSphere(id)) {
            const Sphere& sphere = geometry.sphere(id);
            if (raig::isUsableSphere(sphere.centre, sphere.radius)) items.push_back({sphere.centre, id});
            continue;
        }
        const uvec3 t = geometry.triangles[id];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (raig::isUsable(a, b, c)) items.push_back({a / 3.0f + b / 3.0f + c / 3.0f, id});
    }
    if (items.empty()) return;
    order_.resize(items.size());
    while ((items.size() + (size_t{1} << depth_) - 1) >> depth_ > leafSize) ++depth_;
    boxes_.resize((size_t{2} << depth_) - 1);
    split(items, 0, 0);
    for (size_t i = 0; i < items.size(); ++i) order_[i] = items[i].id;
}

Box Tree::leafBox(const std::vector<Item>& items, size_t begin, size_t end) const {
    Box box;
    for (size_t i = begin; i < end; ++i) {
        if (geometry_->isSphere(items[i].id)) {
            const Sphere& sphere = geometry_->sphere(items[i].id);
            box.grow(sphere.centre - sphere.radius);  // the padding is larger than what is rounded
            box.grow(sphere.centre + sphere.radius);
            continue;
        }
        const uvec3 t = geometry_->triangles[items[i].id];
        box.grow(geometry_->positions[t.x]);
        box.grow(geometry_->positions[t.y]);
        box.grow(geometry_->positions[t.z]);
    }
    const vec3 largest = glm::max(glm::abs(box.lo), glm::abs(box.hi));
    const float padding = 0x1p-20f * std::max({largest.x, largest.y, largest.z}) + std::numeric_limits<float>::min();
    box.lo -= padding;
    box.hi += padding;
    return box;
}

/// Orders the items of a node's share and fills in the boxes from there down.
void Tree::split(std::vector<Item>& items, uint32_t level, size_t position) {
    const size_t begin = firstOf(level, position), end = firstOf(level, position + 1);
    const size_t node = (size_t{1} << level) - 1 + position;
    if (level == depth_) {
        boxes_[node] = leafBox(items, begin, end);
        return;
    }
    Box centres;
    for (size_t i = begin; i < end; ++i) centres.grow(items[i].centre);
    const vec3 extent = centres.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t middle = firstOf(level + 1, 2 * position + 1);
    const auto item = [&](size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
    // Equal centres are ordered by id, so that the tree is the same in every run.
    std::nth_element(item(begin), item(middle), item(end), [axis](const Item& a, const Item& b) {
        return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.id < b.id;
    });
    const auto left = [&] { split(items, level + 1, 2 * position); };
    const auto right = [&] { split(items, level + 1, 2 * position + 1); };
    if (end - begin > 4096) {
        parallelInvoke(left, right);
    } else {
        left();
        right();
    }
    boxes_[node] = boxes_[2 * node + 1];
    boxes_[node].grow(boxes_[2 * node + 2]);
}

void Tree::hitLeaf(Search& search, size_t position) const {
    for (size_t i = firstOf(depth_, position); i < firstOf(depth_, position + 1) && !search.done(); ++i) {
        const uint32_t id = order_[i];
        if (search.any && !search.seeThrough.empty() && search.seeThrough[geometry_->materials[id]]) continue;
        if (geometry_->isSphere(id))
            hitSphere(search, id);
        else
            hitTriangle(search, id);
    }
}

void Tree::take(Search& search, const Hit& hit) {
    if (!(hit.t >= search.ray.tMin && hit.t <= search.best.t)) return;
    if (hit.t < search.best.t || hit.primitive <= search.best.primitive) search.best = hit;
}

void Tree::hitTriangle(Search& search, uint32_t id) const {
    if (id == search.leaving || id == search.arriving) return;
    const uvec3 t = geometry_->triangles[id];
    const auto crossing = cross(search.ray, geometry_->positions[t.x], geometry_->positions[t.y], geometry_->positions[t.z]);
    if (crossing) take(search, {crossing->t, crossing->u, crossing->v, id});
}

void Tree::hitSphere(Search& search, uint32_t id) const {
    const Sphere& sphere = geometry_->sphere(id);
    const auto crossing = crossSphere(search.ray, sphere.centre, sphere.radius);
    if (!crossing) return;
    take(search, {crossing->near, 0.0, 0.0, id});
    take(search, {crossing->far, 0.0, 0.0, id});
}

/// hit(node): both children, the nearer one first; a leaf's triangles.
void Tree::hit(Search& search, uint32_t level, size_t position) const {
    if (level == depth_) return hitLeaf(search, position);
    const size_t left = (size_t{2} << level) - 1 + 2 * position;
    const double enterLeft = search.enter(boxes_[left]), enterRight = search.enter(boxes_[left + 1]);
    const bool rightFirst = enterRight < enterLeft;
    const double nearer = rightFirst ? enterRight : enterLeft, farther = rightFirst ? enterLeft : enterRight;
    if (nearer <= search.best.t && std::isfinite(nearer)) hit(search, level + 1, 2 * position + (rightFirst ? 1 : 0));
    if (farther <= search.best.t && std::isfinite(farther) && !search.done())
        hit(search, level + 1, 2 * position + (rightFirst ? 0 : 1));
}

Hit Tree::closest(const Ray& ray, uint32_t leaving, uint32_t another) const {
    if (order_.empty() || !isUsable(ray)) return {};
    Search search(ray, leaving, another, /* anyHit= */ false, {});
    if (std::isfinite(search.enter(boxes_[0]))) hit(search, 0, 0);
    return search.best.primitive == noTriangle ? Hit{} : search.best;
}

bool Tree::blocked(const Ray& ray, std::span<const uint8_t> seeThrough, uint32_t leaving, uint32_t arriving) const {
    if (order_.empty() || !isUsable(ray)) return false;
    Search search(ray, leaving, arriving, /* anyHit= */ true, seeThrough);
    if (std::isfinite(search.enter(boxes_[0]))) hit(search, 0, 0);
    return search.done();
}

std::vector<Hit> closest(const Tree& tree, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    parallelFor(rays.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) hits[i] = tree.closest(rays[i]);
    });
    return hits;
}

}  // namespace raig::reference

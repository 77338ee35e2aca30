#include "measure/driver_peer.hpp"

#include "base/parallel.hpp"
#include "device/ray_query.hpp"

#include "ray_query.h"

namespace raig {

namespace {

/// Every third bit of the result, from the lowest on, is one of the 10 bits of `x`.
uint32_t spread(uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// The triangles along a Morton curve through the middles of their boxes. Mesa 25.0's llvmpipe builds over them in the order
/// they have: in that of files it was 40 times as slow.
std::vector<uvec3> inSpatialOrder(const Geometry& geometry) {
    const vec3 extent = glm::max(geometry.bounds.hi - geometry.bounds.lo, vec3(1e-30f));
    std::vector<std::pair<uint32_t, uint32_t>> order(geometry.triangles.size());
    parallelFor(order.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = geometry.triangles[i];
            const vec3 &a = geometry.positions[t.x], &b = geometry.positions[t.y], &c = geometry.positions[t.z];
            const vec3 middle = 0.5f * (glm::min(glm::min(a, b), c) + glm::max(glm::max(a, b), c));
            const uvec3 cell(glm::clamp((middle - geometry.bounds.lo) / extent * 1024.0f, vec3(0.0f), vec3(1023.0f)));
            order[i] = {spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2, static_cast<uint32_t>(i)};
        }
    });
    parallelSort(order.begin(), order.end());
    std::vector<uvec3> triangles;
    triangles.reserve(order.size());
    for (const auto& [code, index] : order) triangles.push_back(geometry.triangles[index]);
    return triangles;
}

}  // namespace

DriverPeer::DriverPeer(const DeviceInfo& info, const Geometry& geometry)
    : device_(std::make_unique<Device>(info, DeviceOptions{.rayQuery = true})),
      scene_(std::make_unique<RayQuery>(*device_, geometry.positions, inSpatialOrder(geometry), kernel_ray_query)) {}

DriverPeer::~DriverPeer() = default;

const std::string& DriverPeer::device() const {
    return device_->info().name;
}

std::unique_ptr<ResidentRays> DriverPeer::place(std::span<const Ray> rays, Query query) {
    const auto trace = [this, query](Buffer& from, Buffer& to, uint32_t count) {
        const RunReport ran = scene_->trace(from, to, count, query == Query::any);
        TraceReport report;
        report.seconds = ran.seconds;
        report.deviceSeconds = ran.deviceSeconds;
        return report;
    };
    return std::make_unique<ResidentRays>(trace, *device_, rays);
}

}  // namespace raig

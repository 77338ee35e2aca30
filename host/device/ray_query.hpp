/// The driver's own ray tracing (VK_KHR_ray_query), where a device has it: a peer to be measured. raig's walks do without.
#pragma once

#include "base/vectors.hpp"
#include "device/commands.hpp"

#include <memory>
#include <span>

namespace raig {

/// A scene of triangles as the driver keeps it, and the kernel that asks for hits in it.
class RayQuery {
public:
    /// Has the driver build over triangles, given as indices of positions; none of either may be empty. `device` was opened
    /// with DeviceOptions::rayQuery; `spirv` is of shaders/ray_query.glsl. Throws limitError if it does not fit, deviceError
    /// if the driver cannot.
    RayQuery(Device& device, std::span<const vec3> positions, std::span<const uvec3> triangles,
             std::span<const uint32_t> spirv);
    ~RayQuery();

    /// Traces `count` rays (shared/rays.glsl's Ray, tightly packed) into hits, in dispatches that take about as long as they
    /// may. `anyHit`: the first that is met.
    RunReport trace(const Buffer& rays, const Buffer& hits, uint32_t count, bool anyHit);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace raig

/// The driver's own ray query (VK_KHR_ray_query), the peer that raig is measured against on devices that have it.
#pragma once

#include "measure/timing.hpp"
#include "scene/geometry.hpp"

#include <memory>
#include <string>

namespace raig {

class RayQuery;

/// One scene of triangles in one device's own acceleration structure.
class DriverPeer {
public:
    /// Has the driver build over the scene's triangles, put in spatial order: hits' primitives are no ids. Requires
    /// DeviceFeatures::rayQuery, and a scene of at least one triangle and no spheres. Throws what opening a device and
    /// building throw.
    DriverPeer(const DeviceInfo& info, const Geometry& geometry);
    ~DriverPeer();

    const std::string& device() const;

    /// Rays on the device, to be traced there. The peer and the rays must outlive them.
    std::unique_ptr<ResidentRays> place(std::span<const Ray> rays, Query query);

private:
    std::unique_ptr<Device> device_;
    std::unique_ptr<RayQuery> scene_;
};

}  // namespace raig

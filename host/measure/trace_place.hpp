/// Where charts trace rays: a scene, the rays that are timed in it, and those that hits are checked with.
#pragma once

#include "measure/chart_scene.hpp"
#include "measure/ray_sets.hpp"

#include <memory>
#include <span>

namespace raig {

/// The scene, moved so far along each axis. The picture whose rays are timed frames what it is about: all of it; or, where
/// small things stand in a large place, the box that the middle 98 % of the centres span along each axis, a quarter wider.
class TracePlace {
public:
    static constexpr uint32_t side = 256;             ///< of the picture whose rays are timed
    static constexpr uint32_t judgedRays = 1u << 16;  ///< most aimed rays

    /// `scene` must outlive it. Cost: building raig's bvh, and tracing all rays with it on the CPU.
    TracePlace(const ChartScene& scene, double offset);

    double offset() const { return offset_; }
    const Geometry& geometry() const { return geometry_; }
    const std::vector<Primitive>& primitives() const { return offset_ == 0.0 ? scene_->primitives() : primitives_; }

    /// Rays to check hits with. The yardstick's hits are those of raig's bvh, on the CPU.
    struct Batch {
        std::span<const Ray> rays;
        std::span<const Hit> yardstick;

        Batch first(size_t count) const {
            const size_t all = std::min(count, rays.size());
            return {rays.first(all), yardstick.first(all)};
        }
    };
    Batch aimed() const { return {aimed_, aimedHits_}; }  ///< at edges and corners (aimedRays)
    Batch primary() const { return {sets_.primary, primaryHits_}; }

    /// The set of that name: primary, shadow, diffuse or specular.
    const std::vector<Ray>& rays(const std::string& name) const;
    /// Made when it is first asked for.
    const reference::Tree& tree();

private:
    const ChartScene* scene_;
    double offset_;
    Geometry geometry_;
    std::vector<Primitive> primitives_;
    RaySets sets_;
    std::vector<Ray> aimed_;
    std::vector<Hit> aimedHits_, primaryHits_;
    std::unique_ptr<reference::Tree> tree_;
};

}  // namespace raig

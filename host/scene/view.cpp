#include "scene/view.hpp"

#include "base/error.hpp"
#include "base/triangle.hpp"

#include <algorithm>

namespace raig {

namespace {

std::string textOf(const vec3& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); }

/// The unit vector along v. Requires v != 0; components beyond 1e-150 and below 1e150.
dvec3 unit(const dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

/// The unit vector perpendicular to `axis` (unit) nearest to `v`; nothing if they are parallel, up to 1e-6 of an angle, or v
/// is zero.
std::optional<dvec3> unitAcross(const dvec3& v, const dvec3& axis) {
    if (v == dvec3(0.0)) return std::nullopt;
    const dvec3 along = unit(v);
    const dvec3 across = along - axis * glm::dot(along, axis);
    if (glm::dot(across, across) < 1e-12) return std::nullopt;
    // Once more: the first difference may have cancelled nearly all of it.
    const dvec3 once = unit(across);
    return unit(once - axis * glm::dot(once, axis));
}

dvec3 directionTo(const vec3& at, const Camera& camera, const ViewChange& change) {
    const dvec3 towards = dvec3(at) - dvec3(camera.eye);
    if (towards != dvec3(0.0)) return unit(towards);
    if (!change.at) throw usageError("--eye {}: is the point that the camera looks at; give another by --at", textOf(at));
    throw usageError("--at {}: is where the camera stands; {}", textOf(at),
                     change.eye ? "the point to look at must be another" : "move it by --eye, or look at another point");
}

/// The picture's up for a camera that has been turned to `forward`.
dvec3 upFor(const dvec3& forward, const Camera& before, const ViewChange& change) {
    if (change.up) {
        if (const auto up = unitAcross(dvec3(*change.up), forward)) return *up;
        if (*change.up == vec3(0.0f)) throw usageError("--up {}: is no direction", textOf(*change.up));
        throw usageError("--up {}: the camera looks along it; give another direction", textOf(*change.up));
    }
    for (const dvec3& up : {dvec3(0.0, 1.0, 0.0), dvec3(before.up), -dvec3(before.forward)})
        if (const auto across = unitAcross(up, forward)) return *across;
    RAIG_CHECK(!"two of three directions, two of which are perpendicular, are not parallel to a third");
    return {};
}

}  // namespace

Camera changedView(const Camera& camera, const ViewChange& change) {
    Camera result = camera;
    if (change.eye) result.eye = *change.eye;
    const std::optional<vec3> at = change.at ? change.at : change.eye ? camera.target : std::nullopt;
    if (at || change.up) {
        const dvec3 forward = at ? directionTo(*at, result, change) : unit(dvec3(camera.forward));
        const dvec3 up = upFor(forward, camera, change);
        const dvec3 right = glm::cross(forward, up);
        const bool mirrors = glm::dot(glm::cross(camera.forward, camera.up), camera.right) < 0.0f;
        result.forward = vec3(forward);
        result.up = vec3(up);
        result.right = vec3(mirrors ? -right : right);
    }
    if (at)
        result.target = at;
    else if (change.eye)
        result.target.reset();
    if (change.yfov) {
        if (camera.orthographic)
            throw usageError("--fov: the camera {} is orthographic: its rays are parallel, and have no angle of view",
                             camera.name.empty() ? "(unnamed)" : camera.name);
        result.yfov = *change.yfov;
    }
    return result;
}

void turnHeadlights(Scene& scene, const Camera& camera) {
    for (Light& light : scene.lights)
        if (!light.castsShadows && light.type == Light::Type::directional) light.direction = camera.forward;
}

}  // namespace raig

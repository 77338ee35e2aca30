#include "measure/embree_peer.hpp"

#include "base/parallel.hpp"

#include <atomic>
#include <chrono>
#include <cstring>

#ifdef RAIG_EMBREE
#include <embree3/rtcore.h>
#endif

namespace raig {

#ifdef RAIG_EMBREE

struct EmbreePeer::State {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<RTCRayHit> rays;  // as Embree wants them: it writes into them, so they are made anew for each trace

    ~State() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
};

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

RTCRayHit asEmbrees(const Ray& ray) {
    RTCRayHit result{};
    result.ray.org_x = ray.origin.x;
    result.ray.org_y = ray.origin.y;
    result.ray.org_z = ray.origin.z;
    result.ray.tnear = ray.tMin;
    result.ray.dir_x = ray.direction.x;
    result.ray.dir_y = ray.direction.y;
    result.ray.dir_z = ray.direction.z;
    result.ray.tfar = ray.tMax;
    result.ray.mask = ~0u;
    result.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    return result;
}

/// A copy: Embree reads four bytes past the last vertex of a buffer of one's own.
template <class T>
void fillBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<T>& values) {
    void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), values.size());
    if (buffer) std::memcpy(buffer, values.data(), values.size() * sizeof(T));
}

void attach(RTCGeometry geometry, RTCScene scene) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

std::vector<uvec3> trianglesOnly(const Geometry& geometry) {
    std::vector<uvec3> triangles;
    for (const uvec3& t : geometry.triangles)
        if (t.y != Geometry::noVertex) triangles.push_back(t);
    return triangles;
}

}  // namespace

std::unique_ptr<EmbreePeer> EmbreePeer::make(const Geometry& geometry) {
    auto state = std::make_unique<State>();
    state->device = rtcNewDevice(nullptr);
    if (!state->device) return nullptr;
    const Clock::time_point start = Clock::now();
    state->scene = rtcNewScene(state->device);
    if (geometry.triangleCount() > 0) {
        RTCGeometry triangles = rtcNewGeometry(state->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        fillBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, geometry.positions);
        if (geometry.spheres.empty())
            fillBuffer(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, geometry.triangles);
        else
            fillBuffer(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, trianglesOnly(geometry));
        attach(triangles, state->scene);
    }
    if (!geometry.spheres.empty()) {
        static_assert(sizeof(Sphere) == 4 * sizeof(float), "centre and radius, as Embree has them");
        RTCGeometry spheres = rtcNewGeometry(state->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        fillBuffer(spheres, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, geometry.spheres);
        attach(spheres, state->scene);
    }
    rtcSetSceneBuildQuality(state->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(state->scene);
    if (rtcGetDeviceError(state->device) != RTC_ERROR_NONE) return nullptr;
    return std::unique_ptr<EmbreePeer>(new EmbreePeer(std::move(state), secondsSince(start)));
}

double EmbreePeer::trace(std::span<const Ray> rays, Query query, size_t& hits) {
    state_->rays.resize(rays.size());
    for (size_t i = 0; i < rays.size(); ++i) state_->rays[i] = asEmbrees(rays[i]);
    const Clock::time_point start = Clock::now();
    parallelFor(rays.size(), 4096, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = begin; i < end; ++i) {
            if (query == Query::closest)
                rtcIntersect1(state_->scene, &context, &state_->rays[i]);
            else
                rtcOccluded1(state_->scene, &context, &state_->rays[i].ray);
        }
    });
    const double seconds = secondsSince(start);
    hits = 0;
    for (const RTCRayHit& ray : state_->rays)
        hits += query == Query::closest ? ray.hit.geomID != RTC_INVALID_GEOMETRY_ID : ray.ray.tfar < 0.0f;
    return seconds;
}

#else

struct EmbreePeer::State {};

std::unique_ptr<EmbreePeer> EmbreePeer::make(const Geometry&) { return nullptr; }
double EmbreePeer::trace(std::span<const Ray>, Query, size_t&) { return 0.0; }

#endif

EmbreePeer::EmbreePeer(std::unique_ptr<State> state, double buildSeconds)
    : state_(std::move(state)), buildSeconds_(buildSeconds) {}
EmbreePeer::~EmbreePeer() = default;

}  // namespace raig

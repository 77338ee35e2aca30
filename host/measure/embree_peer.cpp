#include "measure/embree_peer.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/threads.hpp"
#include "measure/timing.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <vector>

#ifdef RAIG_EMBREE
#include <embree3/rtcore.h>
#endif

namespace raig {

#ifdef RAIG_EMBREE

struct EmbreePeer::State {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr, robust = nullptr;
    std::vector<RTCRayHit8> rays;  // or eight RTCRayHit in the place of each; Embree writes into them, so they are made anew
    std::vector<std::vector<uint32_t>> ids;  // of each geometry's primitives; empty: as they are numbered there

    ~State() {
        if (scene) rtcReleaseScene(scene);
        if (robust) rtcReleaseScene(robust);
        if (device) rtcReleaseDevice(device);
    }
};

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t grain = 4096;  // rays of one thread at a time

constexpr size_t width = 8;
static_assert(sizeof(RTCRayHit8) == width * sizeof(RTCRayHit));

void setRay(RTCRayHit& to, const Ray& ray) {
    to = {};
    to.ray.org_x = ray.origin.x;
    to.ray.org_y = ray.origin.y;
    to.ray.org_z = ray.origin.z;
    to.ray.tnear = ray.tMin;
    to.ray.dir_x = ray.direction.x;
    to.ray.dir_y = ray.direction.y;
    to.ray.dir_z = ray.direction.z;
    to.ray.tfar = ray.tMax;
    to.ray.mask = ~0u;
    to.hit.geomID = RTC_INVALID_GEOMETRY_ID;
}

void setPacket(RTCRayHit8& to, std::span<const Ray> rays) {
    to = {};
    for (size_t lane = 0; lane < rays.size(); ++lane) {
        to.ray.org_x[lane] = rays[lane].origin.x;
        to.ray.org_y[lane] = rays[lane].origin.y;
        to.ray.org_z[lane] = rays[lane].origin.z;
        to.ray.tnear[lane] = rays[lane].tMin;
        to.ray.dir_x[lane] = rays[lane].direction.x;
        to.ray.dir_y[lane] = rays[lane].direction.y;
        to.ray.dir_z[lane] = rays[lane].direction.z;
        to.ray.tfar[lane] = rays[lane].tMax;
        to.ray.mask[lane] = ~0u;
        to.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
}

/// How many i below `size` have it.
template <class Has>
uint64_t count(size_t size, const Has& has) {
    return parallelReduce(
        size, grain, uint64_t{0},
        [&](size_t begin, size_t end, uint64_t sum) {
            for (size_t i = begin; i < end; ++i) sum += has(i);
            return sum;
        },
        std::plus<>());
}

/// The loop over single rays, at the beginning of a page. Where the linker happens to put it changed what is measured: of
/// one source, some builds had 48 to 55 million robust primary rays a second in a small scene, others 75 to 85, as a program
/// of Embree's calls alone has.
constexpr size_t page = 4096;

[[gnu::noinline, gnu::aligned(page)]] void askSingles(RTCScene scene, std::span<RTCRayHit> made, Query query) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (RTCRayHit& ray : made) {
        if (query == Query::closest)
            rtcIntersect1(scene, &context, &ray);
        else
            rtcOccluded1(scene, &context, &ray.ray);
    }
}

EmbreePeer::Traced traceSingles(RTCScene scene, std::span<RTCRayHit> made, std::span<const Ray> rays, Query query) {
    parallelFor(rays.size(), grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) setRay(made[i], rays[i]);
    });
    const Clock::time_point start = Clock::now();
    parallelFor(rays.size(), grain,
                [&](size_t begin, size_t end) { askSingles(scene, made.subspan(begin, end - begin), query); });
    const double seconds = secondsSince(start);
    return {seconds, count(rays.size(), [&](size_t i) {
                return query == Query::closest ? made[i].hit.geomID != RTC_INVALID_GEOMETRY_ID : made[i].ray.tfar < 0.0f;
            })};
}

EmbreePeer::Traced tracePackets(RTCScene scene, std::span<RTCRayHit8> made, std::span<const Ray> rays, Query query,
                                bool coherent) {
    const auto lanes = [&](size_t packet) { return std::min(width, rays.size() - packet * width); };
    parallelFor(made.size(), grain / width, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) setPacket(made[i], rays.subspan(i * width, lanes(i)));
    });
    // Not written anew for each packet: a load of the vector right after the stores of its lanes cannot be forwarded from
    // them, and waits, which took a sixth of the time of rays that miss all.
    alignas(32) int whole[width], last[width];
    for (size_t lane = 0; lane < width; ++lane) {
        whole[lane] = -1;
        last[lane] = lane < lanes(made.size() - 1) ? -1 : 0;
    }
    const Clock::time_point start = Clock::now();
    parallelFor(made.size(), grain / width, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        for (size_t i = begin; i < end; ++i) {
            const int* const valid = i + 1 == made.size() ? last : whole;
            if (query == Query::closest)
                rtcIntersect8(valid, scene, &context, &made[i]);
            else
                rtcOccluded8(valid, scene, &context, &made[i].ray);
        }
    });
    const double seconds = secondsSince(start);
    return {seconds, count(rays.size(), [&](size_t i) {
                const RTCRayHit8& packet = made[i / width];
                return query == Query::closest ? packet.hit.geomID[i % width] != RTC_INVALID_GEOMETRY_ID
                                               : packet.ray.tfar[i % width] < 0.0f;
            })};
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

/// The ids of triangles, or of spheres in the order of geometry.spheres; empty where every primitive is a triangle.
std::vector<uint32_t> idsOf(const Geometry& geometry, bool spheres) {
    std::vector<uint32_t> ids(spheres ? geometry.spheres.size() : 0);
    for (uint32_t id = 0; id < geometry.triangles.size() && !geometry.spheres.empty(); ++id) {
        const bool isSphere = geometry.isSphere(id);
        if (isSphere && spheres) ids[geometry.triangles[id].x] = id;
        if (!isSphere && !spheres) ids.push_back(id);
    }
    return ids;
}

std::vector<uvec3> trianglesOnly(const Geometry& geometry) {
    std::vector<uvec3> triangles;
    for (const uvec3& t : geometry.triangles)
        if (t.y != Geometry::noVertex) triangles.push_back(t);
    return triangles;
}

/// Null where Embree cannot.
RTCScene makeScene(RTCDevice device, const Geometry& geometry, RTCSceneFlags flags) {
    const RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    if (geometry.triangleCount() > 0) {
        RTCGeometry triangles = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        fillBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, geometry.positions);
        if (geometry.spheres.empty())
            fillBuffer(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, geometry.triangles);
        else
            fillBuffer(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, trianglesOnly(geometry));
        attach(triangles, scene);
    }
    if (!geometry.spheres.empty()) {
        static_assert(sizeof(Sphere) == 4 * sizeof(float), "centre and radius, as Embree has them");
        RTCGeometry spheres = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        fillBuffer(spheres, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, geometry.spheres);
        attach(spheres, scene);
    }
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) == RTC_ERROR_NONE) return scene;
    rtcReleaseScene(scene);
    return nullptr;
}

}  // namespace

std::unique_ptr<EmbreePeer> EmbreePeer::make(const Geometry& geometry) {
    auto state = std::make_unique<State>();
    state->device = rtcNewDevice(fmt::format("threads={}", threadCount()).c_str());
    if (!state->device) return nullptr;
    const Clock::time_point start = Clock::now();
    state->scene = makeScene(state->device, geometry, RTC_SCENE_FLAG_NONE);
    if (!state->scene) return nullptr;
    const double seconds = secondsSince(start);
    if (geometry.triangleCount() > 0) state->ids.push_back(idsOf(geometry, /* spheres= */ false));
    if (!geometry.spheres.empty()) state->ids.push_back(idsOf(geometry, /* spheres= */ true));
    return std::unique_ptr<EmbreePeer>(new EmbreePeer(std::move(state), seconds));
}

bool EmbreePeer::makeRobust(const Geometry& geometry) {
    if (!state_->robust) state_->robust = makeScene(state_->device, geometry, RTC_SCENE_FLAG_ROBUST);
    return state_->robust != nullptr;
}

void EmbreePeer::copyHits(std::span<Hit> hits, Width width) const {
    const auto* singles = reinterpret_cast<const RTCRayHit*>(state_->rays.data());
    parallelFor(hits.size(), grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const RTCRayHit8& packet = state_->rays[i / raig::width];
            const size_t lane = i % raig::width;
            const bool isSingle = width == Width::single;
            const uint32_t geometry = isSingle ? singles[i].hit.geomID : packet.hit.geomID[lane];
            const uint32_t primitive = isSingle ? singles[i].hit.primID : packet.hit.primID[lane];
            hits[i] = {0.0f, 0.0f, 0.0f, NO_HIT};
            if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
            const std::vector<uint32_t>& ids = state_->ids[geometry];
            hits[i].t = isSingle ? singles[i].ray.tfar : packet.ray.tfar[lane];
            hits[i].primitive = ids.empty() ? primitive : ids[primitive];
        }
    });
}

EmbreePeer::Traced EmbreePeer::trace(std::span<const Ray> rays, Query query, Width width, bool robust) {
    const RTCScene scene = robust ? state_->robust : state_->scene;
    RAIG_CHECK(scene != nullptr);
    const size_t packets = (rays.size() + raig::width - 1) / raig::width;
    if (state_->rays.size() < packets) state_->rays.resize(packets);
    if (width == Width::single)
        return traceSingles(scene, {reinterpret_cast<RTCRayHit*>(state_->rays.data()), rays.size()}, rays, query);
    return tracePackets(scene, std::span(state_->rays).first(packets), rays, query, width == Width::coherentPacket8);
}

std::optional<std::string> embreeVersion() {
    return fmt::format("{}.{}.{}", RTC_VERSION_MAJOR, RTC_VERSION_MINOR, RTC_VERSION_PATCH);
}

#else

struct EmbreePeer::State {};

std::unique_ptr<EmbreePeer> EmbreePeer::make(const Geometry&) {
    return nullptr;
}
bool EmbreePeer::makeRobust(const Geometry&) {
    return false;
}
void EmbreePeer::copyHits(std::span<Hit>, Width) const {}
EmbreePeer::Traced EmbreePeer::trace(std::span<const Ray>, Query, Width, bool) {
    return {};
}
std::optional<std::string> embreeVersion() {
    return std::nullopt;
}

#endif

EmbreePeer::EmbreePeer(std::unique_ptr<State> state, double buildSeconds)
    : state_(std::move(state)), buildSeconds_(buildSeconds) {}
EmbreePeer::~EmbreePeer() = default;

}  // namespace raig

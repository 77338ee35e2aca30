// What `raig bench` measures with: the standard sets of rays, against an independent computation of their definition; the
// time of structures and of Embree over them; threads.
#include "base/threads.hpp"
#include "measure/driver_peer.hpp"
#include "measure/embree_peer.hpp"
#include "measure/ray_sets.hpp"
#include "measure/timing.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"
#include "support/standard_rays.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <numbers>

namespace raig {
namespace {

using namespace test;

/// A square 2 x 2 in the plane y = 0, and one of 1 x 1 at y = 1 over its middle.
Geometry twoSquares() {
    Geometry g;
    for (const auto& [half, y] : {std::pair(1.0f, 0.0f), std::pair(0.5f, 1.0f)}) {
        const auto first = static_cast<uint32_t>(g.positions.size());
        for (const auto& [x, z] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
            g.positions.push_back(vec3(half * float(x), y, half * float(z)));
        g.triangles.push_back({first, first + 1, first + 2});
        g.triangles.push_back({first, first + 2, first + 3});
    }
    for (const vec3& p : g.positions) g.bounds.grow(p);
    return g;
}

RaySets setsOf(const Geometry& g, const Box& framed, uint32_t side) {
    const Structure structure = structureType("bvh").build(primitivesOf(g), {});
    return makeRaySets(g, framed, measuringCamera(g, framed), side, *makeCpuTracer(structure));
}

/// A closed surface with bumps, away from the origin, and a vertex that no triangle names.
Geometry bumps() {
    constexpr uint32_t across = 40, along = 20;
    Geometry g;
    for (uint32_t j = 0; j <= along; ++j)
        for (uint32_t i = 0; i < across; ++i) {
            const double a = 2.0 * i * std::numbers::pi / across, b = j * std::numbers::pi / along;
            const double radius = 2.0 + 0.3 * std::sin(3.0 * a + 1.0) * std::sin(b) + 0.2 * std::cos(5.0 * b);
            g.positions.push_back(vec3(37.3 + radius * std::sin(b) * std::cos(a), -12.9 + 0.7 * radius * std::cos(b),
                                       5.1 + 1.3 * radius * std::sin(b) * std::sin(a)));
        }
    for (uint32_t j = 0; j < along; ++j)
        for (uint32_t i = 0; i < across; ++i) {
            const uint32_t here = j * across + i, beside = j * across + (i + 1) % across;
            g.triangles.push_back({here, beside, here + across});
            g.triangles.push_back({beside, beside + across, here + across});
        }
    for (const vec3& p : g.positions) g.bounds.grow(p);
    g.firstTriangle = {0, static_cast<uint32_t>(g.triangles.size())};
    g.positions.push_back(g.bounds.hi - vec3(0.01f));
    return g;
}

TEST(RaySets, SeeEveryVertexInTheMiddleOfThePicture) {
    const Geometry g = twoSquares();
    const MeasuringCamera camera = measuringCamera(g, g.bounds);
    double most = 0.0;
    for (const vec3& p : g.positions) {
        const dvec3 v = dvec3(p) - camera.eye;
        const double depth = glm::dot(v, camera.forward) * std::tan(22.5 * std::acos(-1.0) / 180.0);
        most = std::max({most, std::abs(glm::dot(v, camera.right)) / depth, std::abs(glm::dot(v, camera.up)) / depth});
    }
    EXPECT_NEAR(most, 0.95, 1e-12);
}

/// How many numbers are as they should be, and how many of them to the last bit: all are rounded once from double
/// precision, which errs by far less than floats can tell, but may so come to lie on the other side of a tie.
struct Agreement {
    size_t all = 0, same = 0;

    bool add(float got, Real exact, Real scale) {
        const Real slack = std::ldexp(scale, -40);
        ++all;
        same += got == static_cast<float>(exact);
        return static_cast<float>(exact - slack) <= got && got <= static_cast<float>(exact + slack);
    }
};

void expectRays(const char* name, const std::vector<Ray>& got, const std::vector<ExactRay>& exact, Agreement& agreement) {
    ASSERT_EQ(got.size(), exact.size()) << name;
    for (size_t k = 0; k < got.size(); ++k) {
        Real scale = 0;
        for (const Real& x : exact[k].origin) scale = std::max(scale, std::abs(x));
        for (int axis = 0; axis < 3; ++axis) {
            ASSERT_TRUE(agreement.add(got[k].origin[axis], exact[k].origin[axis], scale)) << name << ' ' << k;
            ASSERT_TRUE(agreement.add(got[k].direction[axis], exact[k].direction[axis], 1)) << name << ' ' << k;
        }
        ASSERT_TRUE(agreement.add(got[k].tMax, exact[k].tMax, exact[k].tMax)) << name << ' ' << k;
        ASSERT_EQ(got[k].tMin, 0.0f) << name << ' ' << k;
    }
}

void expectStandardSets(const Geometry& g, const Box& framed, uint32_t side) {
    std::vector<Corners> triangles;
    const auto exactly = [](const vec3& p) { return Vector{p.x, p.y, p.z}; };
    for (const uvec3& t : g.triangles)
        triangles.push_back({exactly(g.positions[t.x]), exactly(g.positions[t.y]), exactly(g.positions[t.z])});
    const ExactSets exact = exactSets(triangles, exactly(framed.lo), exactly(framed.hi), side);
    const RaySets got = setsOf(g, framed, side);
    Agreement agreement;
    expectRays("primary", got.primary, exact.primary, agreement);
    expectRays("shadow", got.shadow, exact.shadow, agreement);
    expectRays("diffuse", got.diffuse, exact.diffuse, agreement);
    expectRays("specular", got.specular, exact.specular, agreement);
    EXPECT_GT(agreement.same * 10'000, agreement.all * 9'999) << agreement.same << " of " << agreement.all;
    EXPECT_GT(exact.frontal, side * side / 20);
    EXPECT_GT(exact.averted, 0u) << "both cases of the basis are tried";
    EXPECT_GT(exact.diffuse.size(), exact.shadow.size());
}

TEST(RaySets, HoldTheRaysOfTheirDefinition) {
    const Geometry g = bumps();
    expectStandardSets(g, g.bounds, 48);
}

TEST(RaySets, FrameAPartOfTheScene) {
    const Geometry g = bumps();
    Box part = g.bounds;
    part.lo.x = 0.5f * (part.lo.x + part.hi.x);
    expectStandardSets(g, part, 32);
}

TEST(RaySets, HoldThoseOfARealMesh) {
    const std::filesystem::path bunny = std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/meshes/bunny.ply";
    if (!std::filesystem::exists(bunny)) GTEST_SKIP() << "the real scenes (../shared/scenes) are not here";
    const Geometry g = flatten(importScene(bunny));
    expectStandardSets(g, g.bounds, 16);
}

// Of a cosine-weighted direction, the mean of the cosine is 2/3 and its variance 1/18.
TEST(RaySets, LeaveDiffuseSurfacesByTheCosine) {
    const RaySets sets = setsOf(twoSquares(), twoSquares().bounds, 128);
    double sum = 0.0;
    for (const Ray& ray : sets.diffuse) sum += ray.direction.y;
    const auto count = static_cast<double>(sets.diffuse.size());
    ASSERT_GT(count, 3000.0);
    EXPECT_NEAR(sum / count, 2.0 / 3.0, 4.0 * std::sqrt(1.0 / 18.0 / count));
}

TEST(Quartiles, LieBetweenValues) {
    const Quartiles q = quartilesOf({5.0, 1.0, 4.0, 2.0, 3.0});
    EXPECT_EQ(q.median, 3.0);
    EXPECT_EQ(q.q1, 2.0);
    EXPECT_EQ(q.q3, 4.0);
    EXPECT_EQ(quartilesOf({2.0, 1.0}).median, 1.5);
    EXPECT_EQ(quartilesOf({7.0}).q3, 7.0);
}

TEST(ResidentRays, HitWhatTheTracerDoesWhereverTheyAre) {
    const Geometry g = bumps();
    const Structure structure = structureType("bvh").build(primitivesOf(g), {});
    const std::unique_ptr<Tracer> cpu = makeCpuTracer(structure);
    const RaySets sets = makeRaySets(g, g.bounds, measuringCamera(g, g.bounds), 16, *cpu);
    std::vector<Hit> hits(sets.primary.size());
    const WalkCounters counters = cpu->trace(sets.primary, hits, Query::closest).counters;
    const auto isSame = [&](const std::vector<Hit>& other) {
        return other.size() == hits.size() && std::memcmp(other.data(), hits.data(), hits.size() * sizeof(Hit)) == 0;
    };
    ResidentRays onCpu(*cpu, sets.primary, Query::closest);
    const TraceReport report = onCpu.trace();
    EXPECT_GT(report.seconds, 0.0);
    EXPECT_EQ(report.counters.nodeFetches, counters.nodeFetches);
    EXPECT_TRUE(isSame(onCpu.hits()));
    for (const DeviceInfo& info : listDevices()) {
        Device device(info);
        const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, structure);
        ResidentRays inOne(*tracer, device, sets.primary, Query::closest);
        ResidentRays inThree(*tracer, device, sets.primary, Query::closest, /* batch= */ 100);
        for (ResidentRays* const rays : {&inOne, &inThree}) {
            const TraceReport traced = rays->trace();
            EXPECT_GT(traced.seconds, 0.0);
            EXPECT_EQ(traced.deviceSeconds > 0.0, info.features.timestamps) << info.name;
            EXPECT_LE(traced.deviceSeconds, traced.seconds) << info.name;
            EXPECT_TRUE(isSame(rays->hits())) << info.name;
        }
    }
}

TEST(Embree, FindsTheSameHoweverItIsAsked) {
    const Geometry g = bumps();
    const std::unique_ptr<EmbreePeer> embree = EmbreePeer::make(g);
    ASSERT_EQ(embree != nullptr, embreeVersion().has_value());
    if (!embree) GTEST_SKIP() << "raig was built without Embree";
    EXPECT_GT(embree->buildSeconds(), 0.0);
    ASSERT_TRUE(embree->makeRobust(g));
    std::vector<Ray> rays = setsOf(g, g.bounds, 64).primary;
    std::rotate(rays.begin(), rays.begin() + rays.size() / 2, rays.end());  // from the middle of the picture on
    rays.resize(1001);                                                      // the last packet is not full
    const Structure structure = structureType("brute").build(primitivesOf(g), {});
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    const auto count =
        static_cast<uint64_t>(std::ranges::count_if(hits, [](const Hit& hit) { return hit.primitive != NO_HIT; }));
    ASSERT_GT(count, 100u);
    ASSERT_LT(count, rays.size());
    using Width = EmbreePeer::Width;
    for (const bool robust : {false, true})
        for (const Width width : {Width::single, Width::packet8, Width::coherentPacket8})
            for (const Query query : {Query::closest, Query::any}) {
                const EmbreePeer::Traced traced = embree->trace(rays, query, width, robust);
                EXPECT_GT(traced.seconds, 0.0);
                EXPECT_EQ(traced.hits, count) << int(width) << int(query) << robust;
            }
}

// Nothing on Debian 12 has it; newer versions of Mesa's llvmpipe do.
TEST(Driver, FindsWhatBruteForceFinds) {
    const Geometry g = bumps();
    const std::vector<Ray> rays = setsOf(g, g.bounds, 64).primary;
    std::vector<Hit> hits(rays.size());
    const Structure structure = structureType("brute").build(primitivesOf(g), {});
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    bool hasOne = false;
    for (const DeviceInfo& info : listDevices()) {
        if (!info.features.rayQuery) continue;
        hasOne = true;
        DriverPeer driver(info, g);
        for (const Query query : {Query::closest, Query::any}) {
            const std::unique_ptr<ResidentRays> placed = driver.place(rays, query);
            for (int i = 0; i < 2; ++i) {
                EXPECT_GT(placed->trace().seconds, 0.0);
            }
            const std::vector<Hit>& found = placed->hits();
            ASSERT_EQ(found.size(), hits.size());
            for (size_t k = 0; k < hits.size(); ++k) {
                ASSERT_EQ(found[k].primitive != NO_HIT, hits[k].primitive != NO_HIT) << info.name << ' ' << k;
                if (query == Query::closest && hits[k].primitive != NO_HIT) {
                    EXPECT_NEAR(found[k].t, hits[k].t, 1e-5f * hits[k].t);  // a driver computes as it likes
                }
            }
        }
    }
    if (!hasOne) GTEST_SKIP() << "no device here has VK_KHR_ray_query";
}

TEST(Threads, OfLibrariesAreKeptToFewerProcessors) {
    const auto processors = [] {
        cpu_set_t set;
        return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
    };
    const int before = processors();
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        EXPECT_EQ(threadCount(), 1u);
        const FewerProcessors fewer;
        EXPECT_EQ(processors(), 1);
        EXPECT_EQ(std::async(std::launch::async, processors).get(), 1) << "a thread that is started by it";
    }
    EXPECT_EQ(processors(), before);
    const FewerProcessors asMany;
    EXPECT_EQ(processors(), before);
}

}  // namespace
}  // namespace raig

#include "measure/precision.hpp"

#include "base/error.hpp"
#include "measure/hard_meshes.hpp"
#include "measure/naive.hpp"
#include "measure/timing.hpp"
#include "rays/tracer.hpp"

#include <tbb/task_arena.h>

#include <array>
#include <chrono>

namespace raig {

namespace {

using hard::naive::Tester;

constexpr std::array<std::string_view, 6> methods = {"moeller-trumbore", "float-contracted", "float-precise",
                                                     "float-double",     "double",           "raig"};
constexpr uint32_t rings = 20, edgeRays = 4096, rounds = 3;
constexpr double radius = 100.0;

struct Trial {
    std::vector<Triangle> mesh;
    std::vector<Ray> rays;
};

Trial makeTrial(double offset, uint32_t seed) {
    Trial trial;
    const dvec3 centre(offset);
    trial.mesh = hard::sphere(rings, radius, centre, 0.3);
    Random random(seed);
    const auto aim = [&](const dvec3& target) {
        const vec3 origin(centre);
        trial.rays.push_back({origin, 0.0f, vec3(target - dvec3(origin)), std::numeric_limits<float>::infinity()});
    };
    for (const Triangle& t : trial.mesh) aim(dvec3(t.a));
    for (uint32_t i = 0; i < edgeRays; ++i) {
        const Triangle& t = trial.mesh[random.below(static_cast<uint32_t>(trial.mesh.size()))];
        aim(glm::mix(dvec3(t.a), dvec3(t.b), random.unit()));
    }
    return trial;
}

/// Woop, Benthin and Wald's test, each operation rounded by itself.
template <class Real, bool fallsBack>
bool isMet(const Triangle& t, const Ray& ray) {
    using Vector = glm::vec<3, Real>;
    const Vector d(ray.direction), size = glm::abs(d);
    const int z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2), x = (z + 1) % 3, y = (z + 2) % 3;
    const Real shearX = d[x] / d[z], shearY = d[y] / d[z];
    const auto from = [&](const vec3& corner) { return Vector(corner) - Vector(ray.origin); };
    const Vector a = from(t.a), b = from(t.b), c = from(t.c);
    const Real aX = a[x] - shearX * a[z], aY = a[y] - shearY * a[z], bX = b[x] - shearX * b[z], bY = b[y] - shearY * b[z],
               cX = c[x] - shearX * c[z], cY = c[y] - shearY * c[z];
    Real u = cX * bY - cY * bX, v = aX * cY - aY * cX, w = bX * aY - bY * aX;
    if (fallsBack && (u == 0 || v == 0 || w == 0)) {
        u = static_cast<Real>(double(cX) * bY - double(cY) * bX);
        v = static_cast<Real>(double(aX) * cY - double(aY) * cX);
        w = static_cast<Real>(double(bX) * aY - double(bY) * aX);
    }
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const Real det = u + v + w;
    if (det == 0) return false;
    const Real scaled = (u * a[z] + v * b[z] + w * c[z]) / d[z];
    return (scaled >= 0) == (det > 0);
}

bool meets(std::string_view method, const Triangle& triangle, const Ray& ray) {
    if (method == "moeller-trumbore") {
        const auto t = hard::naive::meets(Tester::moellerTrumbore, triangle, ray);
        return t && *t >= 0.0f;
    }
    if (method == "float-contracted") {
        const auto t = hard::naive::meets(Tester::watertightFused, triangle, ray);
        return t && *t >= 0.0f;
    }
    if (method == "double") return isMet<double, false>(triangle, ray);
    return method == "float-double" ? isMet<float, true>(triangle, ray) : isMet<float, false>(triangle, ray);
}

/// Counts the rays that miss; every triangle is tried by each ray, found or not, so that all methods do the same work.
uint64_t countMisses(std::string_view method, const Trial& trial) {
    uint64_t missed = 0;
    for (const Ray& ray : trial.rays) {
        uint32_t met = 0;
        for (const Triangle& triangle : trial.mesh) met += meets(method, triangle, ray);
        missed += met == 0;
    }
    return missed;
}

uint64_t countMisses(Tracer& brute, const Trial& trial) {
    std::vector<Hit> hits(trial.rays.size());
    brute.trace(trial.rays, hits, Query::closest);
    uint64_t missed = 0;
    for (const Hit& hit : hits) missed += hit.primitive == NO_HIT;
    return missed;
}

}  // namespace

std::span<const std::string_view> precisionMethods() {
    return methods;
}

PrecisionFindings measurePrecision(std::string_view method, double offset, uint32_t seed) {
    const Trial trial = makeTrial(offset, seed);
    const Structure structure = structureType("brute").build(trial.mesh, {});
    const std::unique_ptr<Tracer> brute = makeCpuTracer(structure);
    PrecisionFindings findings{.rays = trial.rays.size()};
    tbb::task_arena oneThread(1);
    std::vector<double> nanoseconds;
    for (uint32_t round = 0; round < rounds; ++round) {
        const auto start = std::chrono::steady_clock::now();
        findings.missed =
            oneThread.execute([&] { return method == "raig" ? countMisses(*brute, trial) : countMisses(method, trial); });
        nanoseconds.push_back(secondsSince(start) * 1e9 / (double(trial.rays.size()) * double(trial.mesh.size())));
    }
    findings.nanoseconds = quartilesOf(nanoseconds).median;
    return findings;
}

}  // namespace raig

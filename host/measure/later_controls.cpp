#include "measure/later_controls.hpp"

#include "measure/naive.hpp"
#include "measure/oracle.hpp"
#include "measure/spawn_policies.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// Case 50: what meets itself, or passes what is next to it, of the rays that leave by the policy.
Control spawnControl(const char* method, double low, double high, SpawnPolicy policy, const SpawnScale& scale, bool leaks,
                     uint64_t rays = 4000) {
    return {50, method, low, high, [=](const hard::Draw& draw) {
                const SpawnFindings found = judgeSpawning(policy, scale, rays, draw.seed);
                return ControlFindings{
                    .rays = found.rays, .missed = leaks ? found.leaks : 0, .phantom = leaks ? 0 : found.selfHits};
            }};
}

/// Case 51: the sphere in the middle of scene `index`. Of the rays that hit it, those that miss it so, or of those that miss
/// it, those that hit it so.
Control sphereControl(const char* method, double low, double high, size_t index, bool misses) {
    return {51,
            method,
            low,
            high,
            [=](const hard::Draw& draw) {
                const hard::Scene scene = hard::caseOf(51).make(draw).at(index);
                const Primitive& sphere = scene.triangles[0];
                const hard::Oracle oracle(std::span(&sphere, 1));
                ControlFindings findings;
                for (const Ray& ray : scene.rays) {
                    const bool hits = oracle.closest(ray).primitive != NO_HIT;
                    if (hits != misses) continue;
                    ++findings.rays;
                    const bool found = hard::naive::meetsSphere(sphere, ray).has_value();
                    findings.missed += misses && !found;
                    findings.phantom += !misses && found;
                }
                return findings;
            },
            12};
}

/// By how many ULP the distance is off, on average, where both have a hit.
Control sphereErrorControl(const char* method, double low, double high, size_t index) {
    return {51,
            method,
            low,
            high,
            [=](const hard::Draw& draw) {
                const hard::Scene scene = hard::caseOf(51).make(draw).at(index);
                const Primitive& sphere = scene.triangles[0];
                const hard::Oracle oracle(std::span(&sphere, 1));
                ControlFindings findings;
                double sum = 0.0;
                for (const Ray& ray : scene.rays) {
                    const Hit exact = oracle.closest(ray);
                    const auto found = hard::naive::meetsSphere(sphere, ray);
                    if (exact.primitive == NO_HIT || !found) continue;
                    ++findings.rays;
                    const double ulp = double{std::nextafter(exact.t, INFINITY)} - double{exact.t};
                    sum += std::abs(double{*found} - double{exact.t}) / ulp;
                }
                findings.measured = findings.rays == 0 ? 0.0 : sum / double(findings.rays);
                return findings;
            },
            12,
            false,
            "ULP"};
}

}  // namespace

std::vector<Control> laterControls() {
    return {
        spawnControl("t >= 0, meets itself", 49.0, 50.0, SpawnPolicy::none, {1.0, 0.0}, false),
        spawnControl("t >= 1e-4, passes what is next to it, at size 1e-3", 100.0, 100.0, SpawnPolicy::smallestT, {1e-3, 0.0},
                     true),
        spawnControl("t >= 1e-4, meets itself, 1e4 off the origin", 32.0, 32.0, SpawnPolicy::smallestT, {1.0, 1e4}, false),
        spawnControl("Waechter-Binder, passes what is next to it, at size 1e-3", 100.0, 100.0, SpawnPolicy::integerSteps,
                     {1e-3, 0.0}, true),
        spawnControl("Waechter-Binder, meets itself, at size 1e6", 0.15, 0.15, SpawnPolicy::integerSteps, {1e6, 0.0}, false,
                     40'000),
        spawnControl("1e-4 along the normal, meets itself, 1e4 off the origin", 0, 0, SpawnPolicy::alongNormal, {1.0, 1e4},
                     false),
        sphereControl("quadratic as at school, misses at 1e4", 30.0, 30.0, 4, true),
        sphereControl("quadratic as at school, phantoms at 1e4", 66.0, 66.0, 4, false),
        sphereErrorControl("quadratic as at school, error of t at 1e2", 95.0, 95.0, 2),
        sphereErrorControl("quadratic as at school, error of t at 1e3", 1731.0, 1731.0, 3),
    };
}

}  // namespace raig

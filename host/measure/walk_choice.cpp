#include "measure/walk_choice.hpp"

#include "base/error.hpp"
#include "device/kept.hpp"
#include "measure/ray_sets.hpp"
#include "rays/primitives.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <vector>

namespace raig {

namespace {

constexpr double clearlyFaster = 0.9;  // of the first walk's time
constexpr uint32_t rings = 48;
constexpr uint32_t side = 96;
constexpr int repetitions = 5;

/// A bumpy sphere in a box that it does not touch.
Geometry measuredScene() {
    Geometry g;
    const auto vertexOf = [](uint32_t ring, uint32_t column) { return ring * 2 * rings + column % (2 * rings); };
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t column = 0; column < 2 * rings; ++column) {
            const double polar = std::numbers::pi * ring / rings, around = std::numbers::pi * column / rings;
            const double radius = 1.0 + 0.1 * std::sin(9.0 * polar) * std::sin(7.0 * around);
            g.positions.push_back(vec3(
                radius * dvec3(std::sin(polar) * std::cos(around), std::cos(polar), std::sin(polar) * std::sin(around))));
        }
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t column = 0; column < 2 * rings; ++column) {
            const uint32_t a = vertexOf(ring, column), b = vertexOf(ring, column + 1);
            const uint32_t c = vertexOf(ring + 1, column), d = vertexOf(ring + 1, column + 1);
            g.triangles.push_back({a, b, c});
            g.triangles.push_back({b, d, c});
        }
    for (const vec3& p : g.positions) g.bounds.grow(p);
    return g;
}

BuildParams paramsOf(size_t candidate) {
    switch (candidate) {
        case 0:
            return {.walk = "octants"};
        case 1:
            return {.walk = "trail", .arity = 2};
        case 2:
            return {.walk = "trail", .arity = 4};
        default:
            return {.walk = "skip"};
    }
}

/// Software takes longest to compile and to walk: there, only those are tried that were the fastest on any that was seen.
bool isTried(size_t candidate, const DeviceInfo& info) {
    return info.type != DeviceType::software || candidate == 0 || candidate == 2;
}

std::string describe(const WalkSeconds& seconds) {
    static constexpr std::array<const char*, triedWalks> names = {"octants", "trail --arity 2", "trail --arity 4", "skip"};
    std::string text;
    for (size_t i = 0; i < triedWalks; ++i)
        if (seconds[i] > 0.0) text += fmt::format("{}{:.2f} ms by {}", text.empty() ? "" : ", ", seconds[i] * 1e3, names[i]);
    return text;
}

WalkSeconds measure(Device& device) {
    const Geometry scene = measuredScene();
    const std::vector<Primitive> triangles = primitivesOf(scene);
    std::vector<Ray> rays;
    std::array<std::unique_ptr<DeviceTracer>, triedWalks> tracers;
    for (size_t candidate = 0; candidate < triedWalks; ++candidate) {
        if (!isTried(candidate, device.info())) continue;
        const Structure structure = structureType("bvh").build(triangles, paramsOf(candidate));
        if (rays.empty()) {
            RaySets sets =
                makeRaySets(scene, scene.bounds, measuringCamera(scene, scene.bounds), side, *makeCpuTracer(structure));
            rays = std::move(sets.primary);
            rays.insert(rays.end(), sets.diffuse.begin(), sets.diffuse.end());
        }
        tracers[candidate] = makeDeviceTracer(device, structure);
    }
    WalkSeconds seconds{};
    std::vector<Hit> hits(rays.size());
    for (int i = 0; i <= repetitions; ++i)
        for (size_t candidate = 0; candidate < triedWalks; ++candidate) {
            if (!tracers[candidate]) continue;
            const double taken = tracers[candidate]->trace(rays, hits, Query::closest).seconds;
            // The first time compiles the kernel.
            if (i > 0) seconds[candidate] = i == 1 ? taken : std::min(seconds[candidate], taken);
        }
    return seconds;
}

std::optional<WalkSeconds> readSeconds(const Device& device, const std::string& what) {
    const auto bytes = readKept(device, what);
    WalkSeconds seconds{};
    if (!bytes || bytes->size() != sizeof seconds) return std::nullopt;
    std::memcpy(seconds.data(), bytes->data(), sizeof seconds);
    const bool sound = std::all_of(seconds.begin(), seconds.end(), [](double s) { return s >= 0.0 && std::isfinite(s); });
    return sound && seconds[0] > 0.0 ? std::optional(seconds) : std::nullopt;
}

}  // namespace

size_t fastestOf(const WalkSeconds& seconds) {
    size_t fastest = 0;
    for (size_t i = 1; i < triedWalks; ++i)
        if (seconds[i] > 0.0 && seconds[i] < seconds[fastest]) fastest = i;
    return seconds[fastest] < clearlyFaster * seconds[0] ? fastest : 0;
}

WalkChoice chooseWalk(Device& device, std::string_view version) {
    const std::string what = fmt::format("walks of bvh, raig {}", version);
    std::optional<WalkSeconds> seconds = readSeconds(device, what);
    const bool known = seconds.has_value();
    if (!known) {
        seconds = measure(device);
        writeKept(device, what, std::as_bytes(std::span(*seconds)));
    }
    const BuildParams chosen = paramsOf(fastestOf(*seconds));
    return {chosen.walk, chosen.arity,
            fmt::format("{}{}: the same rays took {}{}", chosen.walk,
                        chosen.arity > 0 ? fmt::format(" --arity {}", chosen.arity) : "", describe(*seconds),
                        known ? ", in an earlier run" : "")};
}

WalkChoice walkOnCpu() {
    return {"trail", 4, "trail --arity 4: the fastest that was measured on a processor"};
}

}  // namespace raig

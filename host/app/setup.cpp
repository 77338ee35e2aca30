#include "app/setup.hpp"

#include "app/structure_source.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "scene/import.hpp"

#include <charconv>
#include <chrono>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

void describeScene(const Scene& scene, const Geometry& geometry) {
    const std::string spheres = geometry.spheres.empty() ? "" : fmt::format(" and {} spheres", geometry.spheres.size());
    log::note("scene: {} triangles{} in {} instances of {} meshes, {} materials, {} lights, {} cameras, {} images",
              geometry.triangleCount(), spheres, scene.instances.size(), scene.meshes.size(), scene.materials.size(),
              scene.lights.size(), scene.cameras.size(), scene.images.size());
    constexpr size_t shown = 5;
    for (size_t i = 0; i < std::min(shown, scene.remarks.size()); ++i) log::note("remark: {}", scene.remarks[i]);
    if (scene.remarks.size() > shown) log::note("remark: and {} more of the kind", scene.remarks.size() - shown);
    const Dropped& dropped = geometry.dropped;
    if (dropped.nonFinite + dropped.zeroArea + dropped.other > 0)
        log::note(
            "dropped: {} triangles and spheres with a corner that is not finite or out of range, {} without area; {} others",
            dropped.nonFinite, dropped.zeroArea, dropped.other);
}

/// The fastest walk where the scene is to be traced; not measured where that takes longer than it saves.
/// How large a scene is goes by the primitives in memory: of kept instances, those of their meshes, each once.
void setFastestWalk(const std::optional<DeviceInfo>& info, Setup& setup, StructureSource& source) {
    if (!info) return source.setWalk(walkOnCpu());
    if (setup.geometry.triangles.size() < leastForChoice) return;
    setup.device = std::make_unique<Device>(*info);
    const WalkChoice choice = chooseWalk(*setup.device, RAIG_VERSION);
    log::note("walk: {}", choice.why);
    source.setWalk(choice);
}

}  // namespace

std::string Setup::deviceName() const { return device ? device->info().name : "cpu"; }

double Setup::bytesPerTriangle() const {
    return geometry.primitiveCount() == 0 ? 0.0 : double(structure.statistics.bytes) / double(geometry.primitiveCount());
}

std::unique_ptr<Setup> prepare(const Options& options, const std::filesystem::path& file) {
    auto setup = std::make_unique<Setup>();
    // A device or a structure that does not exist should be told before a large scene is read.
    const std::optional<DeviceInfo> info = chooseDevice(options.device);
    StructureSource source(options);

    Clock::time_point start = Clock::now();
    setup->scene = importScene(file);
    setup->geometry = source.keepsInstances(setup->scene) ? gatherInstances(setup->scene) : flatten(setup->scene);
    setup->importSeconds = secondsSince(start);
    describeScene(setup->scene, setup->geometry);

    if (source.leavesWalkOpen()) setFastestWalk(info, *setup, source);
    setup->structure = source.make(setup->scene, setup->geometry);
    setup->buildSeconds = source.buildSeconds();
    setup->loadSeconds = source.loadSeconds();
    const StructureStatistics& built = setup->structure.statistics;
    log::note("structure: {} ({}), {} nodes, depth {}, {:.1f} bytes a triangle, {}", setup->structure.name,
              setup->structure.walk, built.nodes, built.depth, setup->bytesPerTriangle(), source.origin(setup->structure));

    if (setup->structure.isInstanced())
        log::note("instances: {} triangles are {} in memory, in {} places; {:.1f} MiB in all",
                  setup->geometry.primitiveCount(), setup->structure.triangles.size() / shared::TRIANGLE_STRIDE,
                  setup->structure.instances, double(built.bytes) / (1 << 20));

    start = Clock::now();
    if (info) {
        if (!setup->device) setup->device = std::make_unique<Device>(*info);
        std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(*setup->device, setup->structure, options.counters);
        setup->deviceTracer = tracer.get();
        setup->tracer = std::move(tracer);
        log::note("device: {} ({})", info->name, info->driver);
    } else {
        setup->tracer = makeCpuTracer(setup->structure);
        log::note("device: the CPU");
    }
    setup->uploadSeconds = secondsSince(start);
    return setup;
}

uint32_t chooseCamera(const Scene& scene, const std::string& wanted) {
    RAIG_CHECK(!scene.cameras.empty());
    if (wanted.empty()) return 0;
    for (uint32_t i = 0; i < scene.cameras.size(); ++i)
        if (scene.cameras[i].name == wanted) return i;
    uint32_t index = 0;
    const char* end = wanted.data() + wanted.size();
    const auto [last, error] = std::from_chars(wanted.data(), end, index);
    if (error == std::errc() && last == end && index < scene.cameras.size()) return index;
    std::string names;
    for (uint32_t i = 0; i < scene.cameras.size(); ++i)
        names +=
            fmt::format("{}{} {}", i ? ", " : "", i, scene.cameras[i].name.empty() ? "(unnamed)" : scene.cameras[i].name);
    throw usageError("--camera {}: the scene has no such camera; it has: {}", wanted, names);
}

}  // namespace raig

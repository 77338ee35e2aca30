#include "app/setup.hpp"

#include "app/animation_options.hpp"
#include "app/primary_options.hpp"
#include "app/environment_options.hpp"
#include "base/error.hpp"
#include "base/log.hpp"

#include <algorithm>
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
void setFastestWalk(const std::optional<DeviceInfo>& info, const DeviceOptions& open, Setup& setup,
                    StructureSource& source) {
    if (!info) return source.setWalk(walkOnCpu());
    if (setup.geometry.triangles.size() < leastForChoice) return;
    setup.device = std::make_unique<Device>(*info, open);
    const WalkChoice choice = chooseWalk(*setup.device, RAIG_VERSION);
    log::note("walk: {}", choice.why);
    source.setWalk(choice);
}

Geometry gather(const StructureSource& source, const Scene& scene) {
    return source.keepsInstances(scene) ? gatherInstances(scene) : flatten(scene);
}

/// Requires a structure, and a device unless the CPU traces.
void makeTracer(Setup& setup, const Options& options) {
    if (setup.device) {
        std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(*setup.device, setup.structure, options.counters);
        setup.deviceTracer = tracer.get();
        setup.tracer = std::move(tracer);
    } else {
        setup.tracer = makeCpuTracer(setup.structure);
    }
}

Moment momentOf(const Options& options, uint32_t frame) {
    return {secondsOf(options, frame), options.moment.animation};
}

/// True if a structure of the one is a structure of the other: every primitive is in the same place. Corners that are no
/// numbers are not the same.
bool isSameShape(const Scene& a, const Geometry& of, const Scene& b, const Geometry& other) {
    const auto isSameSphere = [](const Sphere& s, const Sphere& t) { return s.centre == t.centre && s.radius == t.radius; };
    const auto isSamePlace = [](const Instance& i, const Instance& k) { return i.mesh == k.mesh && i.toWorld == k.toWorld; };
    return of.isInstanced() == other.isInstanced() && of.positions == other.positions && of.triangles == other.triangles &&
           of.firstTriangle == other.firstTriangle && std::ranges::equal(of.spheres, other.spheres, isSameSphere) &&
           (!of.isInstanced() || std::ranges::equal(a.instances, b.instances, isSamePlace));
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
    setup->source = std::make_unique<StructureSource>(options);
    StructureSource& source = *setup->source;
    checkPrimary(options, info);
    const DeviceOptions open{.graphics = options.primary == Primary::raster};

    Clock::time_point start = Clock::now();
    if (options.frames) {
        setup->moving = std::make_unique<MovingScene>(file);
        setup->scene = setup->moving->at(momentOf(options, options.frames->first));
    } else {
        setup->scene = importScene(file, options.moment);
    }
    setEnvironment(options, setup->scene);
    setup->geometry = gather(source, setup->scene);
    setup->importSeconds = secondsSince(start);
    describeScene(setup->scene, setup->geometry);

    if (source.leavesWalkOpen()) setFastestWalk(info, open, *setup, source);
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
    if (info && !setup->device) setup->device = std::make_unique<Device>(*info, open);
    makeTracer(*setup, options);
    log::note("device: {}", info ? fmt::format("{} ({})", info->name, info->driver) : "the CPU");
    setup->uploadSeconds = secondsSince(start);
    return setup;
}

void moveTo(Setup& setup, const Options& options, uint32_t frame) {
    RAIG_CHECK(setup.moving);
    Scene scene = setup.moving->at(momentOf(options, frame));
    setEnvironment(options, scene);
    Geometry geometry = gather(*setup.source, scene);
    const bool stays = isSameShape(setup.scene, setup.geometry, scene, geometry);
    setup.scene = std::move(scene);
    setup.geometry = std::move(geometry);
    if (stays) return;
    setup.deviceTracer = nullptr;
    setup.tracer.reset();  // before what it refers to
    setup.structure = setup.source->make(setup.scene, setup.geometry);
    setup.buildSeconds = setup.source->buildSeconds();
    makeTracer(setup, options);
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

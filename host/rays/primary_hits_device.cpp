#include "base/error.hpp"
#include "device/commands.hpp"
#include "rays/kernels.hpp"
#include "rays/primary_tiles.hpp"

namespace raig {

using namespace shared;

namespace {

constexpr uint32_t groupSize = 256;

Kernel makeKernel(Device& device, const char* base, const FrameData& data, const BigArray& scene,
                  std::initializer_list<std::pair<uint32_t, const Buffer*>> buffers) {
    const std::string name = std::string(base) + (device.loadsTexel() ? "_texel" : "_storage");
    const auto spirv = findKernel(name);
    RAIG_CHECK(spirv.has_value());
    Kernel kernel(device, name, *spirv,
                  {{/* workgroup size */ 0, groupSize},
                   {/* FEATURES */ 1, data.features},
                   {/* SCENE_CHUNKS */ 2, scene.chunkCount()},
                   {/* SCENE_SHIFT */ 3, scene.chunkShift()}});
    const auto& declared = kernel.interface().bindings;
    for (const auto& [number, buffer] : buffers)
        if (declared.contains(number)) kernel.bind(number, *buffer);
    if (declared.contains(11)) kernel.bind(11, scene);
    return kernel;
}

}  // namespace

PrimaryHits findPrimaryHits(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                            const FrameOptions& options) {
    checkOptions(scene, options);
    PrimaryTiles tiles(scene, geometry, options);
    const BigArray elements(device, std::as_bytes(std::span(tiles.data.elements)));
    tiles.data.elements = {};
    const uint64_t slots = tiles.data.params.slots;
    Buffer frame(device, sizeof(FrameParams)), counter(device, sizeof(uint32_t)), list(device, slots * sizeof(uint32_t)),
        states(device, slots * sizeof(PathState)), rays(device, slots * sizeof(Ray)), hits(device, slots * sizeof(Hit)),
        found(device, slots * sizeof(PrimaryHit));
    frame.uploadValues(std::span<const FrameParams>(&tiles.data.params, 1));
    const std::initializer_list<std::pair<uint32_t, const Buffer*>> buffers = {
        {0, &frame}, {1, &counter}, {2, &list}, {3, &states}, {4, &rays}, {5, &hits}, {12, &found}};
    Kernel begin = makeKernel(device, "begin", tiles.data, elements, buffers);
    Kernel describe = makeKernel(device, "aov", tiles.data, elements, buffers);
    Commands commands(device);
    std::vector<PrimaryHit> tile;
    tiles.forEach([&](const TileStep& step) {
        const uint32_t groups = (step.count + groupSize - 1) / groupSize;
        commands.dispatch(begin, {.x = groups}, step);
        commands.run();
        const auto trace = [&] { tracer.traceBuffers(rays, hits, step.count, Query::closest, false); };
        tiles.find(step, trace, [&](const TileStep& now) {
            if (tiles.passes()) commands.fill(counter, 0);
            commands.dispatch(describe, {.x = groups}, now);
            commands.run();
            return tiles.passes() ? counter.downloadValues<uint32_t>().front() : 0;
        });
        tile.resize(step.count);
        found.download(std::as_writable_bytes(std::span(tile)));
        tiles.take(tile);
    });
    return std::move(tiles.hits);
}

}  // namespace raig

#include "base/error.hpp"
#include "device/commands.hpp"
#include "rays/frame_tiles.hpp"
#include "rays/kernels.hpp"

#include <array>
#include <chrono>

namespace raig {

using namespace shared;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr uint32_t groupSize = 256;
constexpr std::array<const char*, 3> kernelNames = {"begin", "shade", "gather"};

Kernel makeKernel(Device& device, const char* base, uint32_t features, const BigArray& scene) {
    const std::string name = std::string(base) + (device.loadsTexel() ? "_texel" : "_storage");
    const auto spirv = findKernel(name);
    RAIG_CHECK(spirv.has_value());
    return Kernel(device, name, *spirv,
                  {{/* workgroup size */ 0, groupSize},
                   {/* FEATURES */ 1, features},
                   {/* SCENE_CHUNKS */ 2, scene.chunkCount()},
                   {/* SCENE_SHIFT */ 3, scene.chunkShift()}});
}

/// Tiles in a device's memory. Slots' data never leave it, but for the finished pixels and the number at work.
class DeviceTiles : public FrameTiles {
public:
    DeviceTiles(Device& device, FrameData& data, DeviceTracer& tracer, uint32_t slots)
        : tracer_(tracer), slots_(slots), software_(device.info().type == DeviceType::software), commands_(device),
          scene_(device, std::as_bytes(std::span(data.elements))), frame_(device, sizeof(FrameParams)),
          count_(device, sizeof(uint32_t)), list_(device, 2 * sizeof(uint32_t) * uint64_t{slots}),
          states_(device, sizeof(PathState) * uint64_t{slots}), rays_(device, sizeof(Ray) * uint64_t{slots}),
          hits_(device, sizeof(Hit) * uint64_t{slots}),
          pending_(device, sizeof(PendingRay) * std::max<uint64_t>(1, uint64_t{slots} * slotBytes(data).pendingRays)),
          shadowRays_(device, sizeof(Ray) * shadowRoom(data, slots)), shadowHits_(device, sizeof(Hit) * shadowRoom(data, slots)),
          contributions_(device, sizeof(vec4) * shadowRoom(data, slots)),
          results_(device, sizeof(PixelResult) * uint64_t{slots}) {
        data.params.slots = slots;
        frame_.uploadValues(std::span<const FrameParams>(&data.params, 1));
        for (const char* name : kernelNames) {
            kernels_.push_back(makeKernel(device, name, data.features, scene_));
            bindAll(kernels_.back());
        }
    }

    uint32_t slots() const override { return slots_; }
    double longestSeconds() const override { return software_ ? 2.0 : 0.05; }

    double run(FrameKernel kernel, const TileStep& step) override {
        if (kernel == FrameKernel::gather) commands_.fill(count_, 0);
        commands_.dispatch(kernels_[static_cast<size_t>(kernel)], {.x = (step.count + groupSize - 1) / groupSize}, step);
        return commands_.run().seconds;
    }
    double trace(uint32_t count) override { return tracer_.traceBuffers(rays_, hits_, count, Query::closest, false); }
    double traceShadows(uint32_t count) override {
        return tracer_.traceBuffers(shadowRays_, shadowHits_, count, Query::any, true);
    }
    uint32_t counted() override { return count_.downloadValues<uint32_t>().front(); }
    void read(std::span<PixelResult> results) override { results_.download(std::as_writable_bytes(results)); }

private:
    static uint64_t shadowRoom(const FrameData& data, uint32_t slots) {
        return std::max<uint64_t>(1, uint64_t{slots} * data.params.shadowRays);
    }

    void bindAll(Kernel& kernel) {
        const std::array<const Buffer*, 11> buffers = {&frame_,   &count_,      &list_,       &states_,       &rays_,   &hits_,
                                                       &pending_, &shadowRays_, &shadowHits_, &contributions_, &results_};
        const auto& declared = kernel.interface().bindings;
        for (uint32_t i = 0; i < buffers.size(); ++i)
            if (declared.contains(i)) kernel.bind(i, *buffers[i]);
        if (declared.contains(11)) kernel.bind(11, scene_);
    }

    DeviceTracer& tracer_;
    uint32_t slots_;
    bool software_;
    Commands commands_;
    BigArray scene_;
    Buffer frame_, count_, list_, states_, rays_, hits_, pending_, shadowRays_, shadowHits_, contributions_, results_;
    std::vector<Kernel> kernels_;
};

}  // namespace

Picture renderPicture(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                      const FrameOptions& options, const FrameProgress& progress) {
    const Clock::time_point start = Clock::now();
    checkOptions(scene, options);
    FrameData data = packFrame(scene, geometry, options);
    const SlotBytes bytes = slotBytes(data);
    constexpr uint64_t tileBytes = uint64_t{256} << 20;
    const DeviceLimits& limits = device.info().limits;
    const uint64_t mostSlots = std::min({tileBytes / bytes.all, limits.storageBufferBytes / bytes.largest,
                                         uint64_t{limits.workgroupCount[0]} * groupSize,
                                         uint64_t{0xffffffffu} / std::max(1u, data.params.shadowRays)});
    DeviceTiles tiles(device, data, tracer, chooseSlots(options.tilePixels, mostSlots, data));
    data.elements = {};
    Picture picture;
    picture.statistics.setupSeconds = secondsSince(start);
    renderTiles(tiles, data, options, progress, picture);
    picture.statistics.seconds = secondsSince(start);
    return picture;
}

}  // namespace raig

#include "base/error.hpp"
#include "device/commands.hpp"
#include "rays/adaptive.hpp"
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
constexpr std::array<const char*, 4> kernelNames = {"begin", "shade", "gather", "resume"};  // as FrameKernel has them

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

/// Slots in a device's memory. Their data never leave it, but for the finished pixels and the number at work.
class DeviceTiles : public FrameTiles {
public:
    DeviceTiles(Device& device, const FrameData& data, const BigArray& scene, std::span<Kernel> kernels, Commands& commands,
                DeviceTracer& tracer)
        : tracer_(tracer), kernels_(kernels), commands_(commands), params_(data.params), slots_(data.params.slots),
          software_(device.info().type == DeviceType::software), frame_(device, sizeof(FrameParams)),
          count_(device, sizeof(uint32_t)), list_(device, 2 * sizeof(uint32_t) * uint64_t{slots_}),
          states_(device, sizeof(PathState) * uint64_t{slots_}), rays_(device, sizeof(Ray) * uint64_t{slots_}),
          hits_(device, sizeof(Hit) * uint64_t{slots_}),
          pending_(device, sizeof(PendingRay) * std::max<uint64_t>(1, uint64_t{slots_} * slotBytes(data).pendingRays)),
          shadowRays_(device, sizeof(Ray) * shadowRoom(data)), shadowHits_(device, sizeof(Hit) * shadowRoom(data)),
          contributions_(device, sizeof(vec4) * shadowRoom(data)), results_(device, sizeof(PixelResult) * uint64_t{slots_}) {
        setSamples(params_.samples);
        for (Kernel& kernel : kernels_) bindAll(kernel, scene);
    }

    void setSamples(uint32_t samples) override {
        params_.samples = samples;
        frame_.uploadValues(std::span<const FrameParams>(&params_, 1));
    }
    void sendStates(std::span<const PathState> states) override { states_.uploadValues(states); }
    uint32_t slots() const override { return slots_; }
    double longestSeconds() const override { return software_ ? 2.0 : 0.05; }

    double run(FrameKernel kernel, const TileStep& step) override {
        if (kernel == FrameKernel::gather) commands_.fill(count_, 0);
        commands_.dispatch(kernels_[static_cast<size_t>(kernel)], {.x = (step.count + groupSize - 1) / groupSize}, step);
        return commands_.run().seconds;
    }
    double trace(uint32_t count) override {
        return tracer_.traceBuffers(rays_, hits_, count, Query::closest, false).seconds;
    }
    double traceShadows(uint32_t count) override {
        return tracer_.traceBuffers(shadowRays_, shadowHits_, count, Query::any, true).seconds;
    }
    double traceCosts(std::span<uint32_t> costs) override {
        return tracer_.traceBuffersCosts(rays_, hits_, static_cast<uint32_t>(costs.size()), false, costs).seconds;
    }
    double traceShadowsCosts(std::span<uint32_t> costs) override {
        return tracer_.traceBuffersCosts(shadowRays_, shadowHits_, static_cast<uint32_t>(costs.size()), true, costs).seconds;
    }
    void readList(uint32_t at, std::span<uint32_t> slots) override {
        list_.download(std::as_writable_bytes(slots), sizeof(uint32_t) * uint64_t{at});
    }
    uint32_t counted() override { return count_.downloadValues<uint32_t>().front(); }
    void read(std::span<PixelResult> results) override { results_.download(std::as_writable_bytes(results)); }

private:
    static uint64_t shadowRoom(const FrameData& data) {
        return std::max<uint64_t>(1, uint64_t{data.params.slots} * data.params.shadowRays);
    }

    void bindAll(Kernel& kernel, const BigArray& scene) {
        const std::array<const Buffer*, 11> buffers = {&frame_, &count_,   &list_,       &states_,     &rays_,
                                                       &hits_,  &pending_, &shadowRays_, &shadowHits_, &contributions_,
                                                       &results_};
        const auto& declared = kernel.interface().bindings;
        for (uint32_t i = 0; i < buffers.size(); ++i)
            if (declared.contains(i)) kernel.bind(i, *buffers[i]);
        if (declared.contains(11)) kernel.bind(11, scene);
    }

    DeviceTracer& tracer_;
    std::span<Kernel> kernels_;
    Commands& commands_;
    FrameParams params_;
    uint32_t slots_;
    bool software_;
    Buffer frame_, count_, list_, states_, rays_, hits_, pending_, shadowRays_, shadowHits_, contributions_, results_;
};

/// Slots that the device's memory and limits have room for.
uint64_t mostSlots(const Device& device, const FrameData& data) {
    constexpr uint64_t tileBytes = uint64_t{256} << 20;
    const SlotBytes bytes = slotBytes(data);
    const DeviceLimits& limits = device.info().limits;
    return std::min({tileBytes / bytes.all, limits.storageBufferBytes / bytes.largest,
                     uint64_t{limits.workgroupCount[0]} * groupSize,
                     uint64_t{0xffffffffu} / std::max(1u, data.params.shadowRays)});
}

}  // namespace

struct DeviceFrame::State {
    State(Device& d, const Scene& s, const Geometry& g, FrameData packed, DeviceTracer& t)
        : device(d), scene(s), geometry(g), tracer(t), data(std::move(packed)),
          elements(d, std::as_bytes(std::span(data.elements))), commands(d) {
        data.elements = {};
    }

    /// Makes the kernels for what the scene and a picture have, unless the last picture's are such; `resumes`: all of them.
    void specialize(uint32_t features, bool resumes) {
        if (features != data.features) kernels.clear();
        data.features = features;
        for (size_t i = kernels.size(); i < kernelNames.size() - (resumes ? 0 : 1); ++i)
            kernels.push_back(makeKernel(device, kernelNames[i], features, elements));
    }

    Device& device;
    const Scene& scene;
    const Geometry& geometry;
    DeviceTracer& tracer;
    FrameData data;
    BigArray elements;
    std::vector<Kernel> kernels;
    Commands commands;
    double setupSeconds = 0.0;  ///< not yet accounted for by a picture
};

DeviceFrame::DeviceFrame(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer) {
    const Clock::time_point start = Clock::now();
    checkLights(scene);
    state_ = std::make_unique<State>(device, scene, geometry, packFrame(scene, geometry), tracer);
    state_->setupSeconds = secondsSince(start);
}

DeviceFrame::~DeviceFrame() = default;

Picture DeviceFrame::render(const FrameOptions& options, const FrameProgress& progress) {
    const Clock::time_point start = Clock::now();
    State& state = *state_;
    checkOptions(state.scene, options);
    setView(state.scene, state.geometry, withMargin(options), state.data);
    state.specialize(withOptions(state.data.features, options), options.tolerance > 0.0 || options.deadline);
    state.data.params.slots = chooseSlots(options.tilePixels, mostSlots(state.device, state.data), state.data);
    DeviceTiles tiles(state.device, state.data, state.elements, state.kernels, state.commands, state.tracer);
    Picture picture;
    picture.statistics.setupSeconds = state.setupSeconds + secondsSince(start);
    renderTiles(tiles, state.data, options, progress, picture);
    picture.statistics.seconds = state.setupSeconds + secondsSince(start);
    state.setupSeconds = 0.0;
    return picture;
}

Picture renderPicture(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                      const FrameOptions& options, const FrameProgress& progress) {
    checkOptions(scene, options);
    return DeviceFrame(device, scene, geometry, tracer).render(options, progress);
}

}  // namespace raig

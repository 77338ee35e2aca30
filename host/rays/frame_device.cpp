#include "base/error.hpp"
#include "device/commands.hpp"
#include "rays/adaptive.hpp"
#include "rays/frame_tiles.hpp"
#include "rays/item_buffer.hpp"
#include "rays/kernels.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>

namespace raig {

using namespace shared;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr uint32_t groupSize = 256;
/// As FrameKernel has them, and one more.
constexpr std::array<const char*, 6> kernelNames = {"begin", "shade", "gather", "resume", "pass", "hint"};
constexpr size_t resumeKernel = 3, passKernel = 4, hintKernel = 5;
using FrameKernelSet = std::array<std::optional<Kernel>, kernelNames.size()>;

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

/// Looks up in an item buffer what camera rays may meet.
class Hints {
public:
    Hints(Device& device, ItemBuffer& items, Kernel& kernel, Commands& commands, const FrameParams& frame)
        : items_(items), kernel_(kernel), commands_(commands), frame_(frame),
          hints_(device, sizeof(uvec2) * HINTS_A_RAY * uint64_t{frame.slots}) {
        items_.begin(frame_);
        kernel_.bind(12, hints_);
    }

    /// The next tile: its pixels, in the order of pixelOf(), are of so many rows.
    void beginTile(const TileStep& step, uint32_t samples) {
        cameraRays_ += uint64_t{step.count} * samples;
        const uint64_t strip = 8 * uint64_t{frame_.partWidth};
        const uint64_t end = (uint64_t{step.firstPixel} + step.count + strip - 1) / strip * 8;
        items_.show(frame_, static_cast<uint32_t>(step.firstPixel / strip * 8),
                    static_cast<uint32_t>(std::min<uint64_t>(end, frame_.partHeight)));
        kernel_.bind(13, items_.items());
    }

    /// For the rays of `count` entries of the list that begins at `listAt`.
    const Buffer& lookUp(uint32_t count, uint32_t listAt, double& seconds) {
        const TileStep step{.count = count, .listAt = listAt, .nextAt = 0, .compacts = 0, .firstPixel = 0};
        commands_.dispatch(kernel_, {.x = (count + groupSize - 1) / groupSize}, step);
        seconds += commands_.run().seconds;
        return hints_;
    }

    void count(uint64_t failed) { failed_ += failed; }
    void tell(FrameStatistics& statistics) const {
        statistics.hintedRays = cameraRays_;
        statistics.fallbacks = failed_;
        statistics.drawnTriangles = items_.triangles();
        statistics.drawSeconds = items_.seconds();
    }

private:
    ItemBuffer& items_;
    Kernel& kernel_;
    Commands& commands_;
    FrameParams frame_;
    Buffer hints_;
    uint64_t cameraRays_ = 0;
    uint64_t failed_ = 0;
};

/// Slots in a device's memory. Their data never leave it, but for the finished pixels and the number at work.
class DeviceTiles : public FrameTiles {
public:
    DeviceTiles(Device& device, const FrameData& data, const BigArray& scene, FrameKernelSet& kernels, Commands& commands,
                DeviceTracer& tracer, Hints* hints)
        : data_(data), tracer_(tracer), hints_(hints), kernels_(kernels), commands_(commands), params_(data.params),
          slots_(data.params.slots),
          software_(device.info().type == DeviceType::software), frame_(device, sizeof(FrameParams)),
          count_(device, sizeof(uint32_t)), list_(device, 2 * sizeof(uint32_t) * uint64_t{slots_}),
          states_(device, sizeof(PathState) * uint64_t{slots_}), rays_(device, sizeof(Ray) * uint64_t{slots_}),
          hits_(device, sizeof(Hit) * uint64_t{slots_}),
          pending_(device, sizeof(PendingRay) * std::max<uint64_t>(1, uint64_t{slots_} * slotBytes(data).pendingRays)),
          shadowRays_(device, sizeof(Ray) * shadowRoom(data)), shadowHits_(device, sizeof(Hit) * shadowRoom(data)),
          contributions_(device, sizeof(vec4) * shadowRoom(data)), results_(device, sizeof(PixelResult) * uint64_t{slots_}) {
        setSamples(params_.samples);
        for (std::optional<Kernel>& kernel : kernels_)
            if (kernel) bindAll(*kernel, scene);
    }

    void setSamples(uint32_t samples) override {
        params_.samples = samples;
        frame_.uploadValues(std::span<const FrameParams>(&params_, 1));
    }
    void sendStates(std::span<const PathState> states) override { states_.uploadValues(states); }
    uint32_t slots() const override { return slots_; }
    double longestSeconds() const override { return software_ ? 2.0 : 0.05; }

    double run(FrameKernel kernel, const TileStep& step) override {
        if (kernel == FrameKernel::begin && hints_) hints_->beginTile(step, params_.samples);
        if (kernel == FrameKernel::begin || kernel == FrameKernel::resume)
            isHinted_ = hints_ && kernel == FrameKernel::begin;
        if (kernel != FrameKernel::pass) listAt_ = kernel == FrameKernel::gather ? step.nextAt : step.listAt;
        if (kernel == FrameKernel::gather || (kernel == FrameKernel::pass && step.listAt == 0)) commands_.fill(count_, 0);
        commands_.dispatch(*kernels_[static_cast<size_t>(kernel)], {.x = (step.count + groupSize - 1) / groupSize}, step);
        return commands_.run().seconds;
    }
    double trace(uint32_t count) override {
        return hinted(count, [&](const Buffer* hints) {
            return tracer_.traceBuffers(rays_, hits_, count, Query::closest, false, hints);
        });
    }
    double traceShadows(uint32_t count) override {
        const uint32_t through = raysThroughGlass(data_, count);
        double seconds = 0.0;
        if (through > 0) seconds += tracer_.traceBuffers(shadowRays_, shadowHits_, through, Query::any, true).seconds;
        if (count > through)
            seconds += tracer_
                           .traceBuffers(shadowRays_, shadowHits_, count - through, Query::any, false,
                                         /* hints= */ nullptr, through)
                           .seconds;
        return seconds;
    }
    double traceCosts(std::span<uint32_t> costs) override {
        const auto count = static_cast<uint32_t>(costs.size());
        return hinted(count, [&](const Buffer* hints) {
            return tracer_.traceBuffersCosts(rays_, hits_, count, Query::closest, false, costs, hints);
        });
    }
    double traceShadowsCosts(std::span<uint32_t> costs) override {
        const auto count = static_cast<uint32_t>(costs.size());
        const uint32_t through = raysThroughGlass(data_, count);
        const auto trace = [&](uint32_t first, uint32_t some, bool shadows) {
            if (some == 0) return 0.0;
            return tracer_
                .traceBuffersCosts(shadowRays_, shadowHits_, some, Query::any, shadows, costs.subspan(first, some),
                                   /* hints= */ nullptr, first)
                .seconds;
        };
        return trace(0, through, true) + trace(through, count - through, false);
    }
    double traceShadowsToNearest(uint32_t count) override {
        return tracer_.traceBuffers(shadowRays_, shadowHits_, count, Query::closest, false).seconds;
    }
    double traceShadowsToNearestCosts(std::span<uint32_t> costs) override {
        const auto count = static_cast<uint32_t>(costs.size());
        return tracer_.traceBuffersCosts(shadowRays_, shadowHits_, count, Query::closest, false, costs).seconds;
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

    /// Traces the rays of the list at hand, with hints if there are any. Returns seconds.
    template <class Trace>
    double hinted(uint32_t count, const Trace& trace) {
        if (!isHinted_) return trace(nullptr).seconds;
        double seconds = 0.0;
        const TraceReport report = trace(&hints_->lookUp(count, listAt_, seconds));
        hints_->count(report.failedHints);
        return seconds + report.seconds;
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

    const FrameData& data_;
    DeviceTracer& tracer_;
    Hints* hints_;           ///< of tiles that begin, whose pixels lie together
    bool isHinted_ = false;  ///< the tile at work
    FrameKernelSet& kernels_;
    Commands& commands_;
    FrameParams params_;
    uint32_t slots_;
    uint32_t listAt_ = 0;  ///< of the list that is traced next
    bool software_;
    Buffer frame_, count_, list_, states_, rays_, hits_, pending_, shadowRays_, shadowHits_, contributions_, results_;
};

/// Slots that the device's memory and limits have room for.
uint64_t mostSlots(const Device& device, const FrameData& data, bool isHinted) {
    constexpr uint64_t tileBytes = uint64_t{256} << 20;
    const SlotBytes bytes = slotBytes(data);
    const DeviceLimits& limits = device.info().limits;
    const uint64_t hints = isHinted ? HINTS_A_RAY * sizeof(uvec2) : 0;
    return std::min({tileBytes / (bytes.all + hints), limits.storageBufferBytes / bytes.largest,
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

    /// Makes the kernels for what the scene and a picture have, unless there are such.
    void specialize(bool resumes, bool hints) {
        const uint32_t features = data.features;
        if (features != kernelFeatures) kernels = {};
        kernelFeatures = features;
        const bool passes = (features & FEATURE_COVERAGE) != 0;
        for (size_t i = 0; i < kernels.size(); ++i) {
            const bool isWanted = i < resumeKernel || (i == resumeKernel && resumes) || (i == passKernel && passes) ||
                                  (i == hintKernel && hints);
            if (isWanted && !kernels[i]) kernels[i].emplace(makeKernel(device, kernelNames[i], features, elements));
        }
    }

    ItemBuffer& itemsOf(const Structure& structure) {
        if (drawn != &structure) items = std::make_unique<ItemBuffer>(device, structure, tracer);
        drawn = &structure;
        return *items;
    }

    Device& device;
    const Scene& scene;
    const Geometry& geometry;
    DeviceTracer& tracer;
    FrameData data;
    BigArray elements;
    FrameKernelSet kernels;
    uint32_t kernelFeatures = 0;
    Commands commands;
    const Structure* drawn = nullptr;  ///< the structure that `items` is of
    std::unique_ptr<ItemBuffer> items;
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
    takeOptions(options, state.data);
    state.specialize(options.tolerance > 0.0 || options.deadline, options.itemsOf != nullptr);
    state.data.params.slots =
        chooseSlots(options.tilePixels, mostSlots(state.device, state.data, options.itemsOf != nullptr), state.data);
    std::optional<Hints> hints;
    if (options.itemsOf)
        hints.emplace(state.device, state.itemsOf(*options.itemsOf), *state.kernels[hintKernel], state.commands,
                      state.data.params);
    DeviceTiles tiles(state.device, state.data, state.elements, state.kernels, state.commands, state.tracer,
                      hints ? &*hints : nullptr);
    Picture picture;
    picture.statistics.setupSeconds = state.setupSeconds + secondsSince(start);
    renderTiles(tiles, state.data, options, progress, picture);
    picture.statistics.seconds = state.setupSeconds + secondsSince(start);
    state.setupSeconds = 0.0;
    if (hints) hints->tell(picture.statistics);
    return picture;
}

Picture renderPicture(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                      const FrameOptions& options, const FrameProgress& progress) {
    checkOptions(scene, options);
    return DeviceFrame(device, scene, geometry, tracer).render(options, progress);
}

}  // namespace raig

/// What a place that renders tiles offers to the loop over them (rays/frame.cpp): the CPU's memory, or a device.
#pragma once

#include "rays/frame_data.hpp"

#include <span>

namespace raig {

enum class FrameKernel { begin, shade, gather, resume, pass };

/// Bytes of memory that one slot takes: its states, rays and hits, of which the largest array takes `largest`.
struct SlotBytes {
    uint64_t all = 0;
    uint64_t largest = 0;
    uint32_t pendingRays = 0;  ///< room for rays that were put off: none where nothing reflects or lets light through
};

SlotBytes slotBytes(const FrameData& data);

/// Of `count` shadow rays of a step, the first so many pass surfaces that let light through; the others meet all.
uint32_t raysThroughGlass(const FrameData& data, uint32_t count);

/// Slots and the kernels that work on them. Calls run to their end.
class FrameTiles {
public:
    virtual ~FrameTiles() = default;

    /// What pixels are rendered to from now on. At first, data.params.samples.
    virtual void setSamples(uint32_t samples) = 0;
    /// Where the first states.size() slots stand before they resume.
    virtual void sendStates(std::span<const shared::PathState> states) = 0;
    /// Slots there is room for; > 0.
    virtual uint32_t slots() const = 0;
    /// No call of run() should take longer.
    virtual double longestSeconds() const = 0;
    /// One kernel over step.count slots. Returns seconds.
    virtual double run(FrameKernel kernel, const shared::TileStep& step) = 0;
    /// Traces the first `count` rays, or shadow rays, into hits. Returns seconds.
    virtual double trace(uint32_t count) = 0;
    virtual double traceShadows(uint32_t count) = 0;
    /// Shadow rays, to the nearest of all surfaces, those that let light through as well.
    virtual double traceShadowsToNearest(uint32_t count) = 0;
    /// The same, with costs.size() rays and what each of them took (Tracer::traceCosts).
    virtual double traceCosts(std::span<uint32_t> costs) = 0;
    virtual double traceShadowsCosts(std::span<uint32_t> costs) = 0;
    virtual double traceShadowsToNearestCosts(std::span<uint32_t> costs) = 0;
    /// slots.size() entries of the list of slots, from entry `at` on.
    virtual void readList(uint32_t at, std::span<uint32_t> slots) = 0;
    /// What the last gather counted, or the kernels pass since pass was run with listAt 0.
    virtual uint32_t counted() = 0;
    /// Results of the first results.size() slots.
    virtual void read(std::span<shared::PixelResult> results) = 0;
};

/// `wanted` slots, or as many as `mostSlots`, and no more than the picture has pixels.
uint32_t chooseSlots(uint32_t wanted, uint64_t mostSlots, const FrameData& data);

/// A picture made in passes, each over tiles. Until the last is done, `picture` holds sums over the samples, not means.
class FramePasses {
public:
    /// Gives `picture` its size. All must outlive this.
    FramePasses(FrameTiles& tiles, const FrameData& data, const FrameOptions& options, const FrameProgress& progress,
                Picture& picture);

    /// The first `samples` of every pixel, whatever it had before. `share`: of the picture's work, what will then be done.
    void begin(uint32_t samples, double share);
    /// Samples `from` <= index < `to` of some pixels, which are named by their places in `picture` and have `from` of them.
    /// The sums have the same bits as if all were made at once.
    void resume(std::span<const uint32_t> places, uint32_t from, uint32_t to, double share);

    const shared::FrameParams& params() const { return params_; }
    double shareDone() const { return done_; }
    /// Tells that all is done.
    void finish() {
        if (progress_) progress_(1.0, rays_);
    }

private:
    template <class Prepare>
    void run(FrameKernel firstKernel, uint32_t pixels, uint32_t samples, double share, const Prepare& prepare);
    void take(const shared::PixelResult& result, uint32_t cost);

    FrameTiles& tiles_;
    const FrameData& data_;
    const shared::FrameParams& params_;
    const FrameOptions& options_;
    const FrameProgress& progress_;
    Picture& picture_;
    double done_ = 0.0;
    double rays_ = 0.0;
};

/// Renders all tiles. `picture` gets everything but setup seconds.
void renderTiles(FrameTiles& tiles, const FrameData& data, const FrameOptions& options, const FrameProgress& progress,
                 Picture& picture);

/// Throws limitError for a picture, a depth, or a number of lights that is out of reach.
void checkOptions(const Scene& scene, const FrameOptions& options);
void checkLights(const Scene& scene);

}  // namespace raig

#include "rays/frame.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "rays/adaptive.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/frame_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace raig {

using namespace shared;

namespace {

/// Sizes tiles by how long their longest dispatch took.
class TileSize {
public:
    TileSize(const FrameTiles& tiles, uint32_t fixed)
        : tiles_(tiles), fixed_(fixed), next_(std::min(tiles.slots(), fixed ? fixed : firstTile)) {}

    uint32_t next() const { return next_; }
    void learn(double longestSeconds) {
        if (fixed_) return;
        const double factor = std::clamp(0.5 * tiles_.longestSeconds() / std::max(longestSeconds, 1e-6), 0.125, 8.0);
        next_ = static_cast<uint32_t>(std::clamp(next_ * factor, 64.0, double(tiles_.slots())));
    }

private:
    static constexpr uint32_t firstTile = 32768;
    const FrameTiles& tiles_;
    uint32_t fixed_;
    uint32_t next_;
};

struct TileRun {
    double longestSeconds = 0.0;
    double traceSeconds = 0.0;
    double firstSeconds = 0.0;
    uint64_t closestRays = 0;
    uint64_t shadowRays = 0;  ///< at most
};

/// What the pixels of a tile cost, by slot; nothing is counted where it is not wanted.
class TileCosts {
public:
    explicit TileCosts(uint32_t slots) : ofSlot(slots, 0) {}

    double trace(FrameTiles& tiles, const TileStep& step) {
        ofRay_.resize(step.count);
        const double seconds = tiles.traceCosts(ofRay_);
        add(tiles, step);
        return seconds;
    }
    double traceShadows(FrameTiles& tiles, const TileStep& step, uint32_t lights, bool toNearest) {
        ofRay_.resize(size_t{step.count} * lights);
        const double seconds = toNearest ? tiles.traceShadowsToNearestCosts(ofRay_) : tiles.traceShadowsCosts(ofRay_);
        add(tiles, step);
        return seconds;
    }

    std::vector<uint32_t> ofSlot;

private:
    /// Ray k is of entry k % count of the list.
    void add(FrameTiles& tiles, const TileStep& step) {
        list_.resize(step.count);
        tiles.readList(step.listAt, list_);
        for (size_t k = 0; k < ofRay_.size(); ++k) {
            const uint32_t slot = list_[k % step.count];
            if (slot != NO_SLOT) ofSlot[slot] += ofRay_[k];
        }
    }

    std::vector<uint32_t> ofRay_;
    std::vector<uint32_t> list_;
};

/// Traces a step's shadow rays. Where surfaces let light pass by their alpha, from one to the next until all are through or
/// stopped. `run(kernel, step)`. Returns seconds.
template <class Run>
double traceShadows(FrameTiles& tiles, const FrameData& data, const TileStep& step, TileCosts* costs, const Run& run) {
    const uint32_t lights = data.params.shadowRays, count = step.count * lights;
    const bool passing = (data.features & FEATURE_COVERAGE) != 0;
    if (count == 0) return 0.0;
    double seconds = 0.0;
    for (uint32_t passed = 0;; ++passed) {
        if (costs)
            seconds += costs->traceShadows(tiles, step, lights, passing);
        else
            seconds += passing ? tiles.traceShadowsToNearest(count) : tiles.traceShadows(count);
        if (!passing) return seconds;
        for (uint32_t light = 0; light < lights; ++light)
            run(FrameKernel::pass, TileStep{.count = step.count,
                                            .listAt = light * step.count,
                                            .nextAt = 0,
                                            .compacts = passed == MOST_PASSES ? 1u : 0u,
                                            .firstPixel = 0});
        if (tiles.counted() == 0) return seconds;
    }
}

/// Steps one tile to its end, from `first` on: begin or resume. `report(atWork, tile)` after each step.
template <class Report>
TileRun runTile(FrameTiles& tiles, const FrameData& data, FrameKernel first, uint32_t firstPixel, uint32_t count,
                TileCosts* costs, const Report& report) {
    const FrameParams& params = data.params;
    TileRun tile;
    const auto run = [&](FrameKernel kernel, const TileStep& step) {
        tile.longestSeconds = std::max(tile.longestSeconds, tiles.run(kernel, step));
    };
    TileStep step{.count = count, .listAt = 0, .nextAt = params.slots, .compacts = 0, .firstPixel = firstPixel};
    run(first, step);
    for (uint32_t atWork = count; atWork > 0;) {
        const double seconds = costs ? costs->trace(tiles, step) : tiles.trace(step.count);
        tile.traceSeconds += seconds;
        if (tile.closestRays == 0) tile.firstSeconds = seconds;
        run(FrameKernel::shade, step);
        tile.traceSeconds += traceShadows(tiles, data, step, costs, run);
        step.compacts = atWork < step.count - step.count / 4 ? 1 : 0;
        run(FrameKernel::gather, step);
        tile.closestRays += atWork;
        tile.shadowRays += uint64_t{atWork} * params.shadowRays;
        const uint32_t counted = tiles.counted();
        atWork = step.compacts ? counted : atWork - counted;
        step.count = step.compacts ? counted : step.count;
        std::swap(step.listAt, step.nextAt);
        report(atWork, tile);
    }
    return tile;
}

}  // namespace

SlotBytes slotBytes(const FrameData& data) {
    const bool branches = (data.features & (FEATURE_MIRRORS | FEATURE_TRANSMISSION | FEATURE_COVERAGE)) != 0;
    SlotBytes bytes;
    bytes.pendingRays = branches ? data.params.maxDepth + 1 : 0;
    if ((data.features & FEATURE_PATH) != 0) bytes.pendingRays = 1;
    const uint64_t pending = uint64_t{bytes.pendingRays} * sizeof(PendingRay);
    const uint64_t shadow = data.params.shadowRays * (sizeof(Ray) + sizeof(Hit) + sizeof(vec4));
    bytes.all =
        sizeof(PathState) + sizeof(Ray) + sizeof(Hit) + sizeof(PixelResult) + 2 * sizeof(uint32_t) + pending + shadow;
    bytes.largest = std::max({uint64_t{sizeof(PathState)}, pending, uint64_t{data.params.shadowRays} * sizeof(Ray)});
    return bytes;
}

uint32_t raysThroughGlass(const FrameData& data, uint32_t count) {
    if ((data.features & FEATURE_AO) != 0) return 0;
    // Those of the lights come first. To emitters and the environment paths find their ways through glass themselves.
    const uint32_t shadowRays = std::max(data.params.shadowRays, 1u);
    return (data.features & FEATURE_PATH) != 0 ? count / shadowRays * data.params.lightCount : count;
}

uint32_t chooseSlots(uint32_t wanted, uint64_t mostSlots, const FrameData& data) {
    if (mostSlots < 1)
        throw limitError(
            "a pixel's rays need {} bytes, more than a tile may hold; lower --max-depth or the number of lights",
            slotBytes(data).all);
    const uint64_t pixels = uint64_t{data.params.partWidth} * data.params.partHeight;
    return static_cast<uint32_t>(std::min({wanted ? uint64_t{wanted} : mostSlots, mostSlots, pixels}));
}

void checkOptions(const Scene& scene, const FrameOptions& options) {
    RAIG_CHECK(options.width > 0 && options.height > 0);
    RAIG_CHECK(options.samples > 0 && options.samples <= 65536);
    RAIG_CHECK(options.tolerance == 0.0 || (options.tolerance > 0.0 && options.samples >= firstSamples));
    RAIG_CHECK_OP(options.camera, <, scene.cameras.size());
    RAIG_CHECK(options.reach > 0.0f);
    RAIG_CHECK(options.focus > 0.0f && options.aperture >= 0.0f && options.aperture <= 1e6 * options.focus);
    const Crop part = options.part();
    RAIG_CHECK(part.liesIn(options.width, options.height));
    if (uint64_t{options.width} * options.height > uint64_t{1} << 32)
        throw limitError("a picture of {} x {} pixels is too large; one has at most 2^32 pixels", options.width,
                         options.height);
    if (part.pixels() > uint64_t{1} << 31)
        throw limitError("a picture of {} x {} pixels is too large; at most 2^31 pixels can be rendered at once: render it "
                         "in parts, by --crop",
                         part.width, part.height);
    checkLights(scene);
    if (options.maxDepth > 1u << 20)
        throw limitError("a depth of {} is too large; at most 2^20 is possible", options.maxDepth);
}

void checkLights(const Scene& scene) {
    // Some devices stop looping after 65,535 rounds.
    if (scene.lights.size() > 32768)
        throw limitError("the scene has {} lights; at most 32768 can be asked by every point", scene.lights.size());
}

FramePasses::FramePasses(FrameTiles& tiles, const FrameData& data, const FrameOptions& options,
                         const FrameProgress& progress, Picture& picture)
    : tiles_(tiles), data_(data), params_(data.params), options_(options), progress_(progress), picture_(picture) {
    const size_t pixels = size_t{params_.partWidth} * params_.partHeight;
    picture.width = params_.partWidth;
    picture.height = params_.partHeight;
    picture.radiance.resize(pixels);
    picture.discarded.resize(pixels);
    picture.statistics.openMaterials = data.media.openMaterials;
    if (options.keepsLevels) picture.levels.resize(pixels);
    if (options.countsCosts) picture.costs.resize(pixels);
}

void FramePasses::begin(uint32_t samples, double share) {
    std::ranges::fill(picture_.levels, 0u);
    std::ranges::fill(picture_.costs, 0u);
    picture_.statistics.forgottenMedia = 0;
    picture_.statistics.deepest = 0;
    run(FrameKernel::begin, static_cast<uint32_t>(picture_.radiance.size()), samples, share, [](uint32_t, uint32_t) {});
}

void FramePasses::resume(std::span<const uint32_t> places, uint32_t from, uint32_t to, double share) {
    FrameKernels kernels;
    std::vector<PathState> states;
    const auto send = [&](uint32_t first, uint32_t count) {
        states.clear();
        for (const uint32_t place : places.subspan(first, count)) {
            states.push_back(kernels.beginPixel(pixelAtPlace(place, params_)));
            states.back().sum = picture_.radiance[place];
            states.back().discarded = picture_.discarded[place];
            states.back().sampleIndex = from;
        }
        tiles_.sendStates(states);
    };
    run(FrameKernel::resume, static_cast<uint32_t>(places.size()), to, share, send);
}

template <class Prepare>
void FramePasses::run(FrameKernel firstKernel, uint32_t pixels, uint32_t samples, double share, const Prepare& prepare) {
    tiles_.setSamples(samples);
    TileSize size(tiles_, options_.tilePixels);
    std::vector<PixelResult> results;
    for (uint32_t first = 0; first < pixels;) {
        const uint32_t count = std::min(size.next(), pixels - first);
        const auto report = [&](uint32_t atWork, const TileRun& tile) {
            const double part = double(first + (count - atWork)) / pixels;
            if (progress_) progress_(done_ + part * (share - done_), rays_ + double(tile.closestRays + tile.shadowRays));
        };
        std::optional<TileCosts> costs;
        if (options_.countsCosts) costs.emplace(count);
        prepare(first, count);
        const TileRun tile = runTile(tiles_, data_, firstKernel, first, count, costs ? &*costs : nullptr, report);
        size.learn(tile.longestSeconds);
        rays_ += double(tile.closestRays + tile.shadowRays);
        results.resize(count);
        tiles_.read(results);
        picture_.statistics.spared += tile.shadowRays;  // take() takes off those that were traced
        for (uint32_t slot = 0; slot < count; ++slot) take(results[slot], costs ? costs->ofSlot[slot] : 0);
        picture_.statistics.closestRays += tile.closestRays;
        picture_.statistics.traceSeconds += tile.traceSeconds;
        picture_.statistics.firstSeconds += tile.firstSeconds;
        ++picture_.statistics.tiles;
        first += count;
    }
    done_ = share;
}

void FramePasses::take(const PixelResult& result, uint32_t cost) {
    const size_t at = placeInPart(result.pixel, params_);
    picture_.radiance[at] = result.sum;
    picture_.discarded[at] = result.discarded;
    picture_.statistics.shadowRays += result.shadowRays;
    picture_.statistics.spared -= result.shadowRays;
    picture_.statistics.forgottenMedia += result.forgotten;
    picture_.statistics.deepest = std::max(picture_.statistics.deepest, result.deepest);
    if (options_.keepsLevels) picture_.levels[at] = std::max(picture_.levels[at], result.deepest);
    if (options_.countsCosts) picture_.costs[at] += cost;
}

void renderTiles(FrameTiles& tiles, const FrameData& data, const FrameOptions& options, const FrameProgress& progress,
                 Picture& picture) {
    FramePasses passes(tiles, data, options, progress, picture);
    if (options.tolerance > 0.0 || options.deadline) return renderInPasses(passes, options, picture);
    passes.begin(options.samples, 1.0);
    picture.statistics.samples = options.samples;
    const auto samples = static_cast<float>(options.samples);
    for (vec3& radiance : picture.radiance) radiance = radiance / samples;
    for (float& discarded : picture.discarded) discarded = discarded / samples;
}

std::vector<Ray> cameraRays(const Scene& scene, const FrameOptions& options, uint32_t sampleIndex) {
    checkOptions(scene, options);
    FrameKernels kernels;
    setView(scene, options, kernels.frame);
    kernels.FEATURES = withOptions(0, options);
    const Crop part = options.part();
    std::vector<Ray> rays(part.pixels());
    parallelFor(part.height, 16, [&](size_t begin, size_t end) {
        for (size_t i = begin * part.width; i < end * part.width; ++i) {
            const auto x = static_cast<uint32_t>(i % part.width), y = static_cast<uint32_t>(i / part.width);
            rays[i] = kernels.cameraRay((part.y + y) * options.width + part.x + x, sampleIndex);
        }
    });
    return rays;
}

float suitableReach(const Scene& scene, Tracer& tracer, FrameOptions options) {
    options.crop.reset();
    options.aperture = 0.0f;
    options.samples = 1;
    options.tolerance = 0.0;
    options.width = options.height = 32;
    const std::vector<Ray> rays = cameraRays(scene, options);
    std::vector<Hit> hits(rays.size());
    tracer.trace(rays, hits, Query::closest);
    std::erase_if(hits, [](const Hit& hit) { return hit.primitive == NO_HIT; });
    if (hits.empty()) return INFINITY;
    const auto middle = hits.begin() + static_cast<std::ptrdiff_t>(hits.size() / 2);
    std::nth_element(hits.begin(), middle, hits.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
    const Camera& camera = scene.cameras[options.camera];
    const double height = camera.orthographic ? 2.0 * camera.ymag : 2.0 * std::tan(0.5 * camera.yfov) * middle->t;
    const auto reach = static_cast<float>(0.25 * height);
    return reach > 0.0f ? reach : INFINITY;
}

}  // namespace raig

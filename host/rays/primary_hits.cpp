#include "rays/primary_hits.hpp"

#include "base/parallel.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/primary_tiles.hpp"

namespace raig {

using namespace shared;

PrimaryTiles::PrimaryTiles(const Scene& scene, const Geometry& g, const FrameOptions& options)
    : geometry(g), data(packFrame(scene, geometry, /* keepsUvs= */ true)) {
    FrameOptions centre = options;
    centre.samples = 1;
    centre.aperture = 0.0f;  // through the lens's centre
    setView(scene, centre, data.params);
    const Crop part = options.part();
    hits.width = part.width;
    hits.height = part.height;
    hits.pixels.resize(part.pixels());
    data.params.slots = static_cast<uint32_t>(std::min<size_t>(hits.pixels.size(), 65536));
}

void PrimaryTiles::take(std::span<const PrimaryHit> tile) {
    for (const PrimaryHit& found : tile) {
        PrimaryHit& pixel = hits.pixels[placeInPart(found.pixel, data.params)];
        pixel = found;
        if (found.primitive == NO_HIT) continue;
        const Geometry::Place place = geometry.place(found.primitive);
        pixel.primitive = place.primitive;
        pixel.instance = place.instance;
    }
}

PrimaryHits findPrimaryHits(const Scene& scene, const Geometry& geometry, Tracer& tracer, const FrameOptions& options) {
    checkOptions(scene, options);
    PrimaryTiles tiles(scene, geometry, options);
    const uint32_t slots = tiles.data.params.slots;
    std::vector<uint32_t> list(slots);
    std::vector<PathState> states(slots);
    std::vector<Ray> rays(slots);
    std::vector<Hit> hits(slots);
    std::vector<PrimaryHit> found(slots);
    FrameKernels kernels;
    kernels.FEATURES = tiles.data.features;
    kernels.frame = tiles.data.params;
    kernels.slotList = list.data();
    kernels.states = states.data();
    kernels.rays = rays.data();
    kernels.hits = hits.data();
    kernels.primaryHits = found.data();
    kernels.scene = tiles.data.elements;
    tiles.forEach([&](const TileStep& step) {
        const auto each = [&](auto kernel, const TileStep& now) {
            kernels.now = now;
            kernels.counted = 0;
            parallelFor(step.count, 256, [&](size_t begin, size_t end) {
                for (size_t i = begin; i < end; ++i) (kernels.*kernel)(static_cast<uint32_t>(i));
            });
        };
        const auto trace = [&] {
            tracer.trace(std::span(rays).first(step.count), std::span(hits).first(step.count), Query::closest);
        };
        each(&FrameKernels::begin, step);
        tiles.find(step, trace, [&](const TileStep& now) {
            each(&FrameKernels::findPrimaryHit, now);
            return kernels.counted;
        });
        tiles.take(std::span(found).first(step.count));
    });
    return std::move(tiles.hits);
}

}  // namespace raig

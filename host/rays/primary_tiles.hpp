/// What finding primary hits has in common on the CPU and on a device: the scene's data, the tiles, and where results go.
#pragma once

#include "rays/frame_tiles.hpp"
#include "rays/primary_hits.hpp"

#include <algorithm>

namespace raig {

struct PrimaryTiles {
    /// The scene packed, for one sample a pixel. Requires what findPrimaryHits requires; `geometry` must outlive it.
    PrimaryTiles(const Scene& scene, const Geometry& geometry, const FrameOptions& options);

    /// `body(step)` for each tile, of data.params.slots pixels at most.
    template <class Body>
    void forEach(const Body& body) const {
        const auto pixels = static_cast<uint32_t>(hits.pixels.size());
        for (uint32_t first = 0; first < pixels; first += data.params.slots) {
            const uint32_t count = std::min(data.params.slots, pixels - first);
            body(shared::TileStep{.count = count, .listAt = 0, .nextAt = 0, .compacts = 0, .firstPixel = first});
        }
    }

    /// Has a tile's primary hits found. `trace()` traces its rays; `describe(step)` runs findPrimaryHit, and returns how
    /// many go on. Both are called once, and, where surfaces let rays pass by their alpha, until no ray goes on.
    template <class Trace, class Describe>
    void find(shared::TileStep step, const Trace& trace, const Describe& describe) const {
        uint32_t goOn = step.count;
        for (uint32_t passed = 0; goOn > 0 && passed <= shared::MOST_PASSES; ++passed) {
            step.compacts = passed == shared::MOST_PASSES ? 1 : 0;
            trace();
            goOn = describe(step);
        }
    }

    /// Whether rays pass surfaces at all.
    bool passes() const { return (data.features & shared::FEATURE_COVERAGE) != 0; }

    /// Puts a tile's hits where their pixels are. Their ids are global until then.
    void take(std::span<const PrimaryHit> tile);

    const Geometry& geometry;
    FrameData data;
    PrimaryHits hits;
};

}  // namespace raig

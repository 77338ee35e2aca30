/// Which reference of a structure each pixel of a picture shows, by raster: a hint to what its camera rays meet first.
///
/// Source: Weghorst, Hooper, Greenberg 1984, "Improved Computational Methods for Ray Tracing" (item buffer). There the item
/// is what is hit. Here it is a hint: a raster rounds corners to a fraction of a pixel, has few bits of depth, and leaves
/// out what lies between centres of pixels. So it is intersected exactly, and the walk has to prove that nothing is nearer
/// (shaders/hints.glsl): hits are those of a walk without hints.
#pragma once

#include "rays/item_view.hpp"
#include "rays/tracer.hpp"
#include "device/buffer.hpp"

#include <memory>

namespace raig {

class Raster;

class ItemBuffer {
public:
    /// `tracer` traces `structure` on `device`, which was opened with DeviceOptions::graphics; device and tracer outlive
    /// this. Cost: what is drawn is read out of the tracer's arrays: bounds of 1024 references each are all that is kept
    /// beside.
    ItemBuffer(Device& device, const Structure& structure, DeviceTracer& tracer);
    ~ItemBuffer();

    /// The next picture: nothing of it is drawn yet. Of several samples a pixel, which lie between items, there are up to
    /// eight items a sample, 5 x 5 a pixel at most, where they fit. How near the nearest thing is that will be drawn is seen
    /// by tracing some hundred rays.
    void begin(const shared::FrameParams& frame);

    /// Makes sure that rows [first, end) of the part, in pixels, are there; draws as many more as fit. Throws limitError if
    /// memory is short.
    void show(const shared::FrameParams& frame, uint32_t first, uint32_t end);

    /// An ItemWindow, and the items of its rows. Requires show().
    const Buffer& items() const;

    uint32_t scale() const;
    double seconds() const;      ///< taken by drawing since begin()
    uint64_t triangles() const;  ///< drawn since begin()

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace raig

/// Triangles drawn by a device's graphics queue into a picture of two words a pixel: what lies nearest in each.
#pragma once

#include "device/buffer.hpp"
#include "device/kernel.hpp"

namespace raig {

/// One call: gl_VertexIndex counts 3 * triangles, gl_InstanceIndex instances, both from 0.
struct Draw {
    uint32_t triangles = 0;
    uint32_t instances = 1;
    std::array<uint32_t, 4> words{};  ///< the call's own push constants, after those that all have
};

/// A picture and the program that draws into it. The vertex shader pulls what it draws out of buffers; the fragment shader
/// writes a uvec2 at location 0. The greatest depth in [0, 1] wins, the first of equal ones; triangles have two sides.
class Raster {
public:
    /// Both words of a pixel where nothing was drawn.
    static constexpr uint32_t nothing = 0xffffffffu;

    /// Of pictures up to that size, at most largestSide(device) each way. Bindings and push constants are the vertex
    /// shader's, read from its SPIR-V as a Kernel's are; the fragment shader has none, but the same specialization
    /// constants. Requires a device opened with DeviceOptions::graphics. Throws limitError if memory is short, deviceError
    /// if the driver cannot compile it.
    Raster(Device& device, std::string_view name, std::span<const uint32_t> vertex, std::span<const uint32_t> fragment,
           const Constants& constants, uint32_t width, uint32_t height);
    ~Raster();
    Raster(const Raster&) = delete;
    Raster& operator=(const Raster&) = delete;

    static uint32_t largestSide(const Device& device);

    /// As Kernel::bind. All bindings are bound before the first draw(); buffers outlive this.
    void bind(uint32_t binding, const Buffer& buffer);
    void bind(uint32_t binding, const BigArray& array);

    /// Draws into the upper left width x height pixels, which are all of clip space (-1, -1 is their upper left corner), and
    /// waits for it; they are cleared first if `clears`. `push` and each draw's words are the push constants.
    /// Returns seconds.
    double draw(uint32_t width, uint32_t height, bool clears, std::span<const std::byte> push, std::span<const Draw> draws);

    /// Copies those pixels, once something was drawn, into `to`: from byte `offset`, a multiple of 8, on, rows `rowPixels`
    /// apart. Returns seconds.
    double copy(uint32_t width, uint32_t height, Buffer& to, uint64_t offset, uint32_t rowPixels);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace raig

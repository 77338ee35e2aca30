/// Memory on a device: buffers, and arrays too large for one binding.
#pragma once

#include "device/device.hpp"

#include <cstddef>
#include <span>

namespace raig {

namespace vk {
struct BufferState;
}

/// A storage buffer; where the device loads large arrays as texels, and its size is a multiple of 16 that a texel buffer can
/// have, it binds as texels (uvec4), too. Host transfers are complete on return, and ordered with what Commands run before
/// and after. On devices whose memory is the host's (software, most integrated ones) they are plain copies; elsewhere they
/// are staged.
class Buffer {
public:
    /// Contents are undefined. Requires bytes > 0. Throws limitError if memory is short.
    Buffer(Device& device, uint64_t bytes);
    Buffer(Buffer&&) noexcept = default;
    Buffer& operator=(Buffer&&) noexcept = default;

    uint64_t bytes() const;

    /// Requires offset + data.size() <= bytes(), offset and size multiples of 4, and no Commands running.
    void upload(std::span<const std::byte> data, uint64_t offset = 0);
    void download(std::span<std::byte> data, uint64_t offset = 0) const;
    /// Sets each 32-bit word of the buffer (whose size is then a multiple of 4).
    void fill(uint32_t word);

    /// As upload and download, for spans of plain values.
    template <class T>
    void uploadValues(std::span<const T> values, uint64_t offset = 0) {
        upload(std::as_bytes(values), offset);
    }
    template <class T>
    std::vector<T> downloadValues() const {
        std::vector<T> values(bytes() / sizeof(T));
        download(std::as_writable_bytes(std::span(values)));
        return values;
    }

    const std::shared_ptr<vk::BufferState>& state() const { return state_; }

private:
    friend class BigArray;
    Buffer(Device& device, uint64_t bytes, bool texel);
    std::shared_ptr<vk::BufferState> state_;
};

/// A read-only array of 16-byte elements (uvec4 in kernels), in up to `maxChunks` bindings.
///
/// Element i is element (i & ((1 << chunkShift()) - 1)) of chunk (i >> chunkShift()). A kernel declares the binding as an
/// array of descriptors; those beyond chunkCount() are bound to the last chunk. One that fits a single binding has one
/// chunk, and a chunkShift() of 31.
class BigArray {
public:
    static constexpr uint32_t maxChunks = 4;

    /// Copies `data` to the device, zero-padded to a whole number of elements; of empty data, one zero element is made.
    /// Throws limitError, with the size and the limit, if it does not fit `maxChunks` bindings or memory is short.
    BigArray(Device& device, std::span<const std::byte> data);

    uint32_t chunkCount() const { return static_cast<uint32_t>(chunks_.size()); }
    uint32_t chunkShift() const { return shift_; }
    uint64_t elements() const { return elements_; }
    const Buffer& chunk(uint32_t index) const { return chunks_.at(index); }

    /// The most bytes that a BigArray can hold on `device`.
    static uint64_t capacity(const Device& device);

private:
    std::vector<Buffer> chunks_;
    uint32_t shift_ = 31;
    uint64_t elements_ = 0;
};

}  // namespace raig

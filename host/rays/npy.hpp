/// NumPy's .npy files, as far as `raig trace` needs them: rays in, hits out
/// [NumPy Enhancement Proposal 1 and numpy.lib.format: versions 1.0, 2.0, 3.0].
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace raig {

/// A two-dimensional array of floats, row by row.
struct NpyFloats {
    std::vector<float> values;
    size_t rows = 0;
    size_t columns = 0;
};

/// Reads an array of dtype float32 (little-endian), C order and shape (N, columns), N >= 0. The floats are the file's bits:
/// NaN and infinity are not looked at. Rays are (N, 8): ox oy oz tmin dx dy dz tmax, as struct Ray lies in memory.
///
/// Throws inputError saying which of dtype, order, shape or length is not as it should be. Memory: at most twice the
/// length of the file, whatever its header says.
NpyFloats readNpyFloats(const std::filesystem::path& path, size_t columns);

/// As readNpyFloats, of the bytes of a file; `place` names it in errors.
NpyFloats parseNpyFloats(std::span<const std::byte> bytes, size_t columns, const std::string& place);

/// One hit as it lies in the file.
struct NpyHit {
    float t;
    float u;
    float v;
    uint32_t primitive;  ///< 0xffffffff: none
    uint32_t instance;   ///< 0xffffffff: none
};
static_assert(sizeof(NpyHit) == 20, "the structured array has no padding");

/// A structured array of shape (N,) with the fields t, u, v (float32), primitive, instance (uint32), version 1.0. The same
/// hits give the same bits.
std::vector<std::byte> encodeNpyHits(std::span<const NpyHit> hits);

/// Writes encodeNpyHits atomically. Throws an Error if the file cannot be written.
void writeNpyHits(const std::filesystem::path& path, std::span<const NpyHit> hits);

/// A float32 array of shape (rows, columns), as parseNpyFloats reads it. Requires rows * columns values.
std::vector<std::byte> encodeNpyFloats(std::span<const float> values, size_t columns);

}  // namespace raig

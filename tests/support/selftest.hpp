/// What tests of devices and of kernels have in common: the kernels of `raig selftest`, bytes to put in, and validation.
#pragma once

#include "device/device.hpp"
#include "rays/kernels.hpp"

#include <cstdlib>
#include <span>
#include <vector>

namespace raig::test {

/// Turns validation on before the first device is listed, which is when the tests are named.
[[maybe_unused]] const int validationWanted = ::setenv("RAIG_VALIDATION", "1", /* overwrite= */ 0);

/// What kernel selftest_load is told: it copies elements first to first + count - 1 of its array.
struct LoadPush {
    uint32_t first;
    uint32_t count;
};

/// Kernel selftest_load, for arrays of one form or the other (DeviceOptions::loadsTexel).
inline std::span<const uint32_t> loadKernel(bool texel) {
    return findKernel(texel ? "selftest_load_texel" : "selftest_load_storage").value();
}

/// Without the cache of pipelines on disk.
inline DeviceOptions quick(DeviceOptions options = {}) {
    options.diskCache = false;
    return options;
}

/// The same for the same seed.
inline std::vector<std::byte> someBytes(size_t count, uint32_t seed = 1) {
    std::vector<std::byte> bytes(count);
    for (size_t i = 0; i < count; ++i) {
        seed = seed * 1664525u + 1013904223u;
        bytes[i] = static_cast<std::byte>(seed >> 24);
    }
    return bytes;
}

}  // namespace raig::test

/// How much a test should do.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace raig::test {

/// True for `./run test --long`.
inline bool isLong() {
    return std::getenv("RAIG_LONG") != nullptr;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr size_t slowdown = 8;
#else
constexpr size_t slowdown = 1;
#endif

/// As many rays or rounds as take about as long in a build with sanitizers, which is ten times as slow, as `many` do elsewhere.
constexpr size_t affordable(size_t many) {
    return (many + slowdown - 1) / slowdown;
}

}  // namespace raig::test

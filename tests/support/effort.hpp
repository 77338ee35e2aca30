/// How much a test should do.
#pragma once

#include <cstddef>
#include <cstdlib>

namespace raig::test {

/// True for `./run test --long`.
inline bool isLong() {
    return std::getenv("RAIG_LONG") != nullptr;
}

// GCC says so in one way, clang in the other.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RAIG_SLOW 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAIG_SLOW 1
#endif
#endif

/// How many times as long things take in builds with sanitizers, about.
#ifdef RAIG_SLOW
constexpr size_t slowdown = 8;
#else
constexpr size_t slowdown = 1;
#endif

/// As many rays or rounds as take about as long in this build as `many` do in one without sanitizers.
constexpr size_t affordable(size_t many) {
    return (many + slowdown - 1) / slowdown;
}

}  // namespace raig::test

/// Loops, calls, sums and sorts over all cores, by oneTBB. The order in which pieces run is unspecified: write only to what
/// is your own. All of the program's parallel work starts here.
#pragma once

// GCC says so in one way, clang in the other.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define RAIG_PLAIN_THREADS 1
#endif
#endif
#ifdef __SANITIZE_THREAD__
#define RAIG_PLAIN_THREADS 1
#endif

#ifdef RAIG_PLAIN_THREADS
#include "base/plain_threads.hpp"
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <cstddef>
#include <functional>
#include <utility>

namespace raig {

/// Calls `body(begin, end)` for pieces of [0, count), in parallel, of about `grain` indices each.
template <class Body>
void parallelFor(size_t count, size_t grain, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                      [&](const tbb::blocked_range<size_t>& range) { body(range.begin(), range.end()); });
}

/// Calls both, in parallel.
template <class First, class Second>
void parallelInvoke(const First& first, const Second& second) {
    tbb::parallel_invoke(first, second);
}

/// What `over(begin, end, value)` makes of `identity` over [0, count): pieces of about `grain` indices, whose values are
/// joined by `join(a, b)`. The same in every run if it does not matter how the range is cut.
template <class Value, class Over, class Join>
Value parallelReduce(size_t count, size_t grain, const Value& identity, const Over& over, const Join& join) {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, count, grain), identity,
        [&](const tbb::blocked_range<size_t>& range, Value value) {
            return over(range.begin(), range.end(), std::move(value));
        },
        join);
}

/// Sorts [begin, end) by `before`, a strict total order: else the outcome may differ from run to run.
template <class Iterator, class Before = std::less<>>
void parallelSort(Iterator begin, Iterator end, const Before& before = {}) {
    tbb::parallel_sort(begin, end, before);
}

}  // namespace raig
#endif

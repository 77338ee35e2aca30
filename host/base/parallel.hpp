/// Loops over all cores, by oneTBB. The order in which pieces run is unspecified: write only to your own index.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace raig {

/// Calls `body(begin, end)` for pieces of [0, count), in parallel, of about `grain` indices each.
template <class Body>
void parallelFor(size_t count, size_t grain, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                      [&](const tbb::blocked_range<size_t>& range) { body(range.begin(), range.end()); });
}

}  // namespace raig

/// Hits in tests, and whether they are the same.
#pragma once

#include "rays/tracer.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace raig::test {

inline bool sameBits(const Hit& a, const Hit& b) {
    return std::memcmp(&a, &b, sizeof(Hit)) == 0;
}

inline bool sameBits(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0);
}

/// A hit for each ray, on the CPU.
inline std::vector<Hit> traceOnCpu(const Structure& structure, const std::vector<Ray>& rays, Query query = Query::closest) {
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, query);
    return hits;
}

/// Expects as many hits as rays, the same by bits, and tells the first that is not.
inline void expectSame(const std::vector<Hit>& got, const std::vector<Hit>& want, const std::vector<Ray>& rays,
                       const std::string& what) {
    for (size_t i = 0; i < rays.size(); ++i)
        ASSERT_TRUE(sameBits(got[i], want[i]))
            << what << " ray " << i << ' ' << describe(rays[i]) << " got " << got[i].primitive << ' ' << got[i].t << " want "
            << want[i].primitive << ' ' << want[i].t;
}

}  // namespace raig::test

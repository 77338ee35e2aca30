/// How often rays slip through a closed mesh, by how precisely triangles are tested, and what that costs.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace raig {

/// What a way to test triangles did.
struct PrecisionFindings {
    uint64_t rays = 0;
    uint64_t missed = 0;       ///< rays that hit nothing, though each must
    double nanoseconds = 0.0;  ///< a test, on one thread: the median of several rounds
};

/// The ways there are:
///     moeller-trumbore   in float [Moeller, Trumbore 1997]
///     float-contracted   Woop's test in float, with multiply-adds [Woop, Benthin, Wald 2013]: calls, so time says little
///     float-precise      the same, each operation rounded by itself
///     float-double       the same, and in double precision again where an edge function is 0, as in the paper
///     double             in double precision, of the same floats
///     raig               raig's own, with all that a walk does beside: u, v, and ties by id; its structure `brute`
std::span<const std::string_view> precisionMethods();

/// Rays from inside a closed, bumpy sphere of radius 100, whose centre is moved by `offset` along each axis, at all its
/// vertices and at random points of its edges: each must hit. The same rays for every method. `method` is one of those
/// above. Cost: some 10^8 tests.
PrecisionFindings measurePrecision(std::string_view method, double offset, uint32_t seed);

}  // namespace raig

/// How rays are kept from meeting the surface that they leave: raig's error bounds beside what others do, judged by exact
/// arithmetic.
///
/// A ray hits a triangle, and another leaves the point that was found there. It must not meet that triangle again (a
/// self-hit), nor pass a second one that lies close by on its side (a leak).
#pragma once

#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace raig {

enum class SpawnPolicy : uint8_t {
    none,          ///< from o + t d, tMin = 0
    smallestT,     ///< the same, tMin = 1e-4
    alongNormal,   ///< from o + t d + 1e-4 n
    integerSteps,  ///< 256 n floats on [Waechter, Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection"]
    bounds,        ///< raig's own: the code that devices run, shaders/spawn.glsl
};
inline constexpr std::array<SpawnPolicy, 5> spawnPolicies = {
    SpawnPolicy::none, SpawnPolicy::smallestT, SpawnPolicy::alongNormal, SpawnPolicy::integerSteps, SpawnPolicy::bounds};

/// "error bounds", say, or "t >= 1e-4".
const char* nameOf(SpawnPolicy policy);

/// Where the triangles are.
struct SpawnScale {
    double size = 1.0;   ///< the radius of the body whose surface they are on: their sides are up to a third as long
    double place = 0.0;  ///< how far the body lies from the origin, along each axis
    /// From the one triangle to the other, as a part of the size; but no less than 8 ULP of the distance |p| of its nearest
    /// corner from the origin: 0 for that. (Error bounds grow with the triangle, too:
    /// where it is longer than a third of |p|, they may be wider than that.)
    double gap = 1e-3;
};

/// Sizes 1e-6 to 1e6 and places 0, 1e4 and 1e6, as far as floats can tell such triangles' corners from each other.
std::vector<SpawnScale> spawnScales(double gap);

struct SpawnFindings {
    uint64_t rays = 0;
    uint64_t selfHits = 0;
    uint64_t leaks = 0;
};

/// A triangle, and one next to it, on the side of which all its rays leave.
struct SpawnPair {
    Triangle left, next;
    vec3 side{0.0f};  ///< unit, as shaders/spawn.glsl finds it
};

/// Triangles of all shapes but slivers, some in planes of coordinates. Requires a size of at least 1e-4 of the place.
std::vector<SpawnPair> spawnPairs(const SpawnScale& scale, size_t count, uint32_t seed);

/// `count` rays that leave `pair.left` by that policy, at all angles of more than 6 degrees above it: the way they are
/// to be traced.
std::vector<Ray> spawnRays(SpawnPolicy policy, const SpawnPair& pair, const SpawnScale& scale, size_t count, uint32_t seed);

/// What becomes of `rays` rays, in exact arithmetic: of 8 each from a pair. A ray is a self-hit or a leak, never both: the
/// former if it meets what it left. All policies get the same triangles, hits and directions.
/// Requires as spawnPairs. The same arguments give the same numbers. Cost: some 7 microseconds a ray, on one core.
SpawnFindings judgeSpawning(SpawnPolicy policy, const SpawnScale& scale, uint64_t rays, uint32_t seed);

}  // namespace raig

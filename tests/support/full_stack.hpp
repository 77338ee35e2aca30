/// The walk that all others save memory against: near first, with a stack of any depth.
#pragma once

#include "rays/tracer.hpp"

#include <vector>

namespace raig::test {

/// Finds what each ray hits nearest, in a bvh laid out for --walk trail: of the children that a ray meets, the nearest is
/// visited first; the others wait on a stack with the distances at which they are entered, and those that are no nearer than
/// what has been hit by their turn are dropped unread. Adds to nodeFetches, triangleTests and boxTests.
std::vector<Hit> traceWithFullStack(const Structure& structure, const std::vector<Ray>& rays, WalkCounters& counters);

}  // namespace raig::test

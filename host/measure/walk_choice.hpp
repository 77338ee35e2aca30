/// Which walk of bvh is the fastest on a device: measured there, once.
#pragma once

#include "device/device.hpp"
#include "structures/structure.hpp"

#include <array>
#include <string>
#include <string_view>

namespace raig {

/// The walks that are tried, in this order: octants; trail with 2 and with 4 children a node; skip. All with planes that
/// suit the scene. The first is the default: another must be clearly faster.
inline constexpr size_t triedWalks = 4;

/// Seconds of each on the same rays; 0 of those that were not tried, which octants always are.
using WalkSeconds = std::array<double, triedWalks>;

struct WalkChoice {
    std::string walk = "octants";
    uint32_t arity = 0;  ///< of BuildParams
    std::string why;     ///< one line
};

/// The rule, in one place: the fastest, unless it saves less than a tenth of what the first takes; then the first.
size_t fastestOf(const WalkSeconds& seconds);

/// With fewer primitives than this, choosing takes longer than it saves.
inline constexpr uint64_t leastForChoice = 50'000;

/// Measures, or knows from an earlier run what was measured with the same device, driver and `version` of raig. Measuring
/// takes a mesh of some thousand triangles and some thousand rays, and compiling a kernel for each walk that is tried. The
/// answer may differ from run to run where walks are about as fast; what is traced with it does not.
WalkChoice chooseWalk(Device& device, std::string_view version);

/// Of the CPU path, where nothing need be measured: trail with 4 children a node. With one thread of an AMD EPYC it renders
/// bunny in 0.15 s of processor time and classroom in 0.40, where octants take 0.17 and 0.53, trail with 2 children 0.17 and
/// 0.47, with 8 0.17 and 0.44.
WalkChoice walkOnCpu();

}  // namespace raig

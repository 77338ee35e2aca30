/// Speed of structures over the standard sets of rays, side by side with Embree in one run.
#pragma once

#include "measure/ray_sets.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raig {

struct Quartiles {
    double median = 0.0, q1 = 0.0, q3 = 0.0;
};

/// Of at least one value; between two, the mean of them by their distance.
Quartiles quartilesOf(std::vector<double> values);

struct BenchSettings {
    uint32_t side = 1024;       ///< of the picture that primary rays belong to; a multiple of 8
    uint32_t repetitions = 7;   ///< of each measurement, in turn with the peer's; two more to warm up
    std::vector<std::string> structures;
    BuildParams params;
    const DeviceInfo* device = nullptr;  ///< none: the CPU path
};

struct BenchResult {
    std::string structure, walk, rays;
    uint64_t count = 0;  ///< of rays
    uint64_t hits = 0;
    uint64_t embreeHits = 0;
    Quartiles megaRays;                    ///< a second, wall time
    std::optional<Quartiles> embree;       ///< the same of Embree, in the same run
    std::optional<Quartiles> toEmbree;     ///< of pairs measured one after the other: above 1, raig is faster
    WalkCounters counters;
};

struct BenchBuild {
    std::string structure, walk;
    Quartiles seconds;
    std::optional<Quartiles> toEmbree;  ///< raig's seconds over Embree's
    StructureStatistics statistics;
};

struct BenchReport {
    std::vector<BenchBuild> builds;
    std::vector<BenchResult> results;
};

/// Builds and traces one scene. `progress` is told what is at hand and the share done, before each step.
/// Throws what building and opening devices throw.
BenchReport bench(const Geometry& geometry, const BenchSettings& settings,
                  const std::function<void(const std::string&, double)>& progress);

}  // namespace raig

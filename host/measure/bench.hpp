/// Speed of structures over the standard sets of rays, side by side with Embree in one run.
#pragma once

#include "measure/ray_sets.hpp"
#include "measure/timing.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raig {

struct BenchSettings {
    uint32_t side = 1024;      ///< of the picture that primary rays belong to; a multiple of 8
    uint32_t repetitions = 7;  ///< of each measurement, in turn with the peer's; two more to warm up
    std::vector<std::string> structures;
    BuildParams params;
    std::vector<std::optional<DeviceInfo>> devices;  ///< nothing: the CPU path
    bool bothQueries = false;  ///< of each set; else the one that such rays are for: any of shadow, closest of the others
};

/// Names of the peers, where structures have theirs.
inline constexpr const char* embreeName = "embree";
inline constexpr const char* driverName = "driver";
inline bool isPeer(std::string_view structure) {
    return structure == embreeName || structure == driverName;
}

struct BenchResult {
    std::string structure;  ///< or the peer
    std::string walk;       ///< of a peer, how it is asked: single, packet8, single robust, packet8 robust; ray query
    std::string device;     ///< its name; of the CPU path and of Embree, cpu
    std::string rays;       ///< primary, shadow, diffuse or specular
    Query query = Query::closest;
    uint64_t count = 0;  ///< of rays
    uint64_t hits = 0;
    Quartiles megaRays;                       ///< a second, wall time
    std::optional<Quartiles> deviceMegaRays;  ///< a second of the device's own clock, where it has one
    std::optional<WalkCounters> counters;     ///< none of a peer's

    /// Embree as it is by default, ray by ray, in the same run. `ratio` is of pairs measured one after the other: above 1,
    /// this is faster than Embree.
    struct ToEmbree {
        Quartiles megaRays, ratio;
        uint64_t hits = 0;
    };
    std::optional<ToEmbree> toEmbree;
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
    std::vector<std::string> withoutDriver;  ///< devices that have ray queries, but could not make one of the scene; and why
};

/// Builds and traces one scene. Embree's other ways are measured once a scene, beside the first structure. `progress` is
/// told what is at hand and the share done, before each step. Throws what building and opening devices throw. Memory: one
/// structure at a time, and 300 bytes a ray of the largest set.
BenchReport bench(const Geometry& geometry, const BenchSettings& settings,
                  const std::function<void(const std::string&, double)>& progress);

}  // namespace raig

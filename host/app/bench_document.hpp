/// What `raig bench` found, as it is written: tables for a person, one document for a program.
#pragma once

#include "measure/bench.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace raig {

/// What was measured of one scene.
struct SceneBenches {
    std::string scene;       ///< the name of its file
    uint64_t triangles = 0;  ///< spheres among them
    std::string options;     ///< of the structures, as given
    BenchReport report;
};

/// The keys of the results and builds of one scene, appended to those of `document`.
void addJson(nlohmann::ordered_json& document, const SceneBenches& benches);

/// On standard output, at most 125 columns wide.
void printTables(const SceneBenches& benches);

}  // namespace raig

/// What walks counted, as the commands print it. Tests of triangles and spheres have two keys for the one number:
/// primitive_tests, and triangle_tests, as they were called when there were no spheres.
#pragma once

#include "rays/tracer.hpp"

#include <nlohmann/json.hpp>

namespace raig {

inline nlohmann::ordered_json toJson(const WalkCounters& counters) {
    return {{"node_fetches", counters.nodeFetches},
            {"box_tests", counters.boxTests},
            {"triangle_tests", counters.triangleTests},
            {"primitive_tests", counters.triangleTests},
            {"link_reads", counters.linkReads}};
}

}  // namespace raig

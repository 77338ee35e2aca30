/// What walks counted, as the commands print it.
#pragma once

#include "rays/tracer.hpp"

#include <nlohmann/json.hpp>

namespace raig {

inline nlohmann::ordered_json toJson(const WalkCounters& counters) {
    return {{"node_fetches", counters.nodeFetches},
            {"box_tests", counters.boxTests},
            {"primitive_tests", counters.triangleTests},
            {"link_reads", counters.linkReads}};
}

}  // namespace raig

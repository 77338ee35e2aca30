/// The options that say which acceleration structure is built, and how.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// --memory-budget.
void addMemoryBudget(CLI::App& app, Options& options);

/// --accel, --walk and what else a structure is built by, --memory-budget and --seed. `more`, up to its comma, stands for
/// other than one structure: auto, or all; with auto also --instances, --save-structure and --load-structure.
void addStructure(CLI::App& app, Options& options, const std::string& more = "auto, which picks one for the scene",
                  const std::string& byDefault = "bvh");

}  // namespace raig

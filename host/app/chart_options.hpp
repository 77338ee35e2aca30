/// The options of `raig chart` that no other command has.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds the scenes, --output, --sweep, --figure and --fresh, and examples.
void addChartOptions(CLI::App& command, Options& options);

}  // namespace raig

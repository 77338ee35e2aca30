/// The options of `raig bench`.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds all of them, and examples.
void addBenchOptions(CLI::App& command, Options& options);

}  // namespace raig

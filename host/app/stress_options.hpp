/// The options of `raig stress`.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds all of them, and examples.
void addStressOptions(CLI::App& command, Options& options);

}  // namespace raig

/// How camera rays find what they meet first: the option of `raig render`, and what is needed for it.
#pragma once

#include "app/options.hpp"
#include "device/device.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --primary.
void addPrimaryOptions(CLI::App& command, Options& options);

/// Throws if what --primary asks for cannot be had there: usageError on the CPU path, deviceError on a device without a
/// queue that draws.
void checkPrimary(const Options& options, const std::optional<DeviceInfo>& device);

}  // namespace raig

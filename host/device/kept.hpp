/// What was found out about a device, kept between runs beside its compiled pipelines. Whatever goes wrong there only costs
/// time.
#pragma once

#include "device/device.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace raig {

/// What writeKept was given for the same driver, device and `what`, if it is there whole. `what` is a word or several: what
/// it is, and the version of whoever made it.
std::optional<std::vector<std::byte>> readKept(const Device& device, std::string_view what);

/// Nothing happens where the device was opened without a disk cache, or there is no cache folder.
void writeKept(const Device& device, std::string_view what, std::span<const std::byte> bytes);

}  // namespace raig

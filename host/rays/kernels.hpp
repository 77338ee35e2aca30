/// The kernels that were compiled into the program.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace raig {

/// The SPIR-V of kernel `name`: the .comp file's name with "_storage" or "_texel" for the way it loads large buffers.
std::optional<std::span<const uint32_t>> findKernel(std::string_view name);

}  // namespace raig

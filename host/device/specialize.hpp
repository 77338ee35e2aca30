/// SPIR-V made smaller before a driver sees it.
#pragma once

#include "device/kernel.hpp"

#include <vector>

namespace raig::vk {

/// `spirv` with its specialization constants replaced by their values (`constants`, defaults elsewhere), and without the
/// code that they leave out. Drivers translate and optimise all of a kernel before they look at what is used: this takes
/// SwiftShader from seconds a kernel to a tenth of one, and llvmpipe to a quarter of its time.
///
/// Requires  constants of 32 bits, all of them declared (reflect() refuses others).
/// Ensures   no instruction that stays is changed, but for those whose operands are all constant: results are the same bits,
///           as arithmetic is IEEE 754's, and no kernel takes a sine or the like of a constant. Bindings that nothing uses
///           any more are gone.
/// Cost      20 ms for the largest of raig's kernels.
/// Errors    RAIG_CHECK where `spirv` cannot be read.
std::vector<uint32_t> specialize(std::string_view name, std::span<const uint32_t> spirv, const Constants& constants);

}  // namespace raig::vk

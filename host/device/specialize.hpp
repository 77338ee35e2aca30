/// SPIR-V made smaller before a driver sees it.
#pragma once

#include "device/kernel.hpp"

#include <vector>

namespace raig::vk {

/// `spirv` with its specialization constants replaced by their values (`constants`, defaults elsewhere), and without the
/// code that they leave out. Drivers translate and optimise all of a kernel before they look at what is used: this takes
/// SwiftShader from seconds a kernel to a tenth of one, and llvmpipe to a quarter of its time.
///
/// Ensures   no instruction that stays is changed, but for those whose operands are all constant (IEEE arithmetic): results
///           are the same bits. The interface may have fewer members.
/// Cost      20 ms for the largest of raig's kernels.
/// Errors    RAIG_CHECK where `spirv` is not valid, or a value is of other than 32 bits.
std::vector<uint32_t> specialize(std::string_view name, std::span<const uint32_t> spirv, const Constants& constants);

}  // namespace raig::vk

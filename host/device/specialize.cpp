#include "device/specialize.hpp"

#include "base/error.hpp"

#include <spirv-tools/optimizer.hpp>

#include <unordered_map>

namespace raig::vk {

// Passes that inline functions or simplify arithmetic are left out: the first save no more than they cost, the second may
// round otherwise than the same statements on a CPU.
std::vector<uint32_t> specialize(std::string_view name, std::span<const uint32_t> spirv, const Constants& constants) {
    std::unordered_map<uint32_t, std::vector<uint32_t>> values;
    for (const auto& [id, value] : constants) values[id] = {value};

    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_1);
    std::string error;
    optimizer.SetMessageConsumer([&](spv_message_level_t level, const char*, const spv_position_t&, const char* message) {
        if (level <= SPV_MSG_ERROR) error = message;
    });
    optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
        .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
        .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
        .RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        .RegisterPass(spvtools::CreateAggressiveDCEPass());
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);  // a driver's validation layer does, where it is asked for
    std::vector<uint32_t> result;
    if (!optimizer.Run(spirv.data(), spirv.size(), &result, options))
        checkFailed(__FILE__, __LINE__, fmt::format("kernel {}: can be specialized ({})", name, error));
    return result;
}

}  // namespace raig::vk

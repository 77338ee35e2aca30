// `raig devices`: the Vulkan devices and the CPU, what they can hold, and what their arithmetic was measured to do.
#include "app/commands.hpp"
#include "app/machine.hpp"
#include "base/error.hpp"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> listFeatures(const DeviceFeatures& features) {
    const std::pair<bool, const char*> all[] = {{features.float64, "float64"},
                                                {features.int64, "int64"},
                                                {features.int16, "int16"},
                                                {features.bufferDeviceAddress, "buffer device address"},
                                                {features.scalarBlockLayout, "scalar block layout"},
                                                {features.timestamps, "timestamps"},
                                                {features.rayQuery, "ray query"},
                                                {features.graphics, "graphics"}};
    std::vector<std::string> names;
    for (const auto& [found, name] : all)
        if (found) names.emplace_back(name);
    return names;
}

Json toJson(const DeviceLimits& limits) {
    return {{"storage_buffer_bytes", limits.storageBufferBytes},
            {"texel_buffer_elements", limits.texelBufferElements},
            {"allocation_bytes", limits.allocationBytes},
            {"memory_bytes", limits.memoryBytes},
            {"workgroup_size", limits.workgroupSize},
            {"workgroup_invocations", limits.workgroupInvocations},
            {"workgroup_count", limits.workgroupCount},
            {"shared_memory_bytes", limits.sharedMemoryBytes},
            {"push_constant_bytes", limits.pushConstantBytes},
            {"subgroup_size", limits.subgroupSize},
            {"timestamp_ns", limits.timestampNanoseconds}};
}

Json toJson(const DeviceFeatures& features) {
    return {{"float64", features.float64},
            {"int64", features.int64},
            {"int16", features.int16},
            {"buffer_device_address", features.bufferDeviceAddress},
            {"scalar_block_layout", features.scalarBlockLayout},
            {"timestamps", features.timestamps},
            {"ray_query", features.rayQuery},
            {"graphics", features.graphics},
            {"denormals_can_be_kept", features.keepsDenormals},
            {"denormals_can_be_flushed", features.flushesDenormals},
            {"nan_can_be_kept", features.keepsNan},
            {"subgroup_operations", features.subgroupOperations}};
}

Json toJson(const DeviceInfo& device) {
    return {{"index", device.index},
            {"name", device.name},
            {"driver", device.driver},
            {"type", describe(device.type)},
            {"vulkan", device.apiVersion},
            {"large_arrays", device.prefersTexel ? "texel" : "storage"},
            {"limits", toJson(device.limits)},
            {"features", toJson(device.features)},
            {"arithmetic", toJson(measureArithmetic(device))}};
}

Json cpuJson() {
    return {{"index", "cpu"},
            {"name", "cpu"},
            {"driver", ""},
            {"type", "cpu"},
            {"limits", Json::object()},
            {"features", Json::object()},
            {"arithmetic", toJson(MeasuredArithmetic{measureHostArithmetic(), ""})}};
}

std::string describeBytes(uint64_t bytes) {
    const double mebibytes = static_cast<double>(bytes) / (1 << 20);
    if (mebibytes < 1.0) return fmt::format("{} bytes", bytes);
    return mebibytes < 1024.0 ? fmt::format("{:.0f} MiB", mebibytes) : fmt::format("{:.4g} GiB", mebibytes / 1024.0);
}

void printLine(const char* what, const std::string& text) {
    std::fputs(fmt::format("     {:<11} {}\n", what, text).c_str(), stdout);
}

void print(const DeviceInfo& device) {
    const DeviceLimits& limits = device.limits;
    std::fputs(fmt::format("{:<4} {} [{}]\n", device.index, device.name, describe(device.type)).c_str(), stdout);
    printLine("driver", fmt::format("{}, Vulkan {}", device.driver, device.apiVersion));
    printLine("memory", fmt::format("{}; a storage buffer {}, a texel buffer {} elements; large arrays are {} buffers",
                                    describeBytes(limits.memoryBytes), describeBytes(limits.storageBufferBytes),
                                    limits.texelBufferElements, device.prefersTexel ? "texel" : "storage"));
    printLine("workgroup", fmt::format("{} invocations at most, {} of them in step, {} shared", limits.workgroupInvocations,
                                       limits.subgroupSize, describeBytes(limits.sharedMemoryBytes)));
    printLine("has", fmt::format("{}", fmt::join(listFeatures(device.features), ", ")));
    printLine("subgroups", fmt::format("{}", fmt::join(device.features.subgroupOperations, ", ")));
    printLine("arithmetic", describe(measureArithmetic(device)));
}

}  // namespace

int devices(const Options& options) {
    if (options.json) {
        Json list = Json::array();
        for (const DeviceInfo& device : listDevices()) list.push_back(toJson(device));
        list.push_back(cpuJson());
        // Names come from drivers: what is not UTF-8 in them must not spoil the document.
        std::fputs((list.dump(2, ' ', false, Json::error_handler_t::replace) + "\n").c_str(), stdout);
        return static_cast<int>(ExitCode::done);
    }
    for (const DeviceInfo& device : listDevices()) print(device);
    std::fputs("cpu  the CPU path, without Vulkan\n", stdout);
    printLine("arithmetic", describe(MeasuredArithmetic{measureHostArithmetic(), ""}));
    return static_cast<int>(ExitCode::done);
}

}  // namespace raig

#include "device/device.hpp"

#include "base/threads.hpp"
#include "device/cache.hpp"
#include "device/vulkan.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace raig {

namespace {

std::string lowered(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

std::string listNames() {
    std::string names;
    for (const DeviceInfo& device : listDevices()) names += fmt::format("{} ({}), ", device.index, device.name);
    return names + "cpu";
}

std::optional<uint32_t> parseIndex(std::string_view text) {
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// Buffers are mapped where the device's memory is the host's, and cached: reading uncached memory is 100 times slower.
bool canMapAll(const DeviceInfo& info, const VkPhysicalDeviceMemoryProperties& memory) {
    if (info.type != DeviceType::software && info.type != DeviceType::integrated) return false;
    const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                         VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((memory.memoryTypes[i].propertyFlags & wanted) == wanted) return true;
    return false;
}

void openQueue(Device::State& state, VkPhysicalDevice physical) {
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = vk::init<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = state.queueFamily;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkPhysicalDeviceBufferDeviceAddressFeatures address = vk::init<VkPhysicalDeviceBufferDeviceAddressFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = vk::init<VkPhysicalDeviceAccelerationStructureFeaturesKHR>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR);
    VkPhysicalDeviceRayQueryFeaturesKHR queries =
        vk::init<VkPhysicalDeviceRayQueryFeaturesKHR>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR);
    address.pNext = &structures;
    structures.pNext = &queries;
    address.bufferDeviceAddress = structures.accelerationStructure = queries.rayQuery = VK_TRUE;
    const char* const extensions[] = {VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                      VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_QUERY_EXTENSION_NAME};
    const VkPhysicalDeviceFeatures none{};  // robustBufferAccess above all: it costs, and indices are checked where built
    VkDeviceCreateInfo create = vk::init<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.pEnabledFeatures = &none;
    if (state.options.rayQuery) {
        create.pNext = &address;
        create.enabledExtensionCount = std::size(extensions);
        create.ppEnabledExtensionNames = extensions;
    }
    vk::check(vkCreateDevice(physical, &create, nullptr, &state.handle), "be opened");
    volkLoadDeviceTable(&state.call, state.handle);
    state.call.vkGetDeviceQueue(state.handle, state.queueFamily, 0, &state.queue);

    VkCommandPoolCreateInfo pool = vk::init<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = state.queueFamily;
    vk::check(state.call.vkCreateCommandPool(state.handle, &pool, nullptr, &state.commandPool), "record commands");
}

}  // namespace

const char* describe(DeviceType type) {
    return type == DeviceType::software ? "software" : "hardware";
}

const std::vector<DeviceInfo>& listDevices() {
    static const std::vector<DeviceInfo> list = [] {
        std::vector<DeviceInfo> infos;
        for (const vk::Physical& device : vk::physicalDevices()) infos.push_back(device.info);
        return infos;
    }();
    return list;
}

std::optional<DeviceInfo> chooseDevice(std::string_view wanted) {
    const std::string name = lowered(wanted);
    if (name == "cpu") return std::nullopt;
    const std::vector<DeviceInfo>& devices = listDevices();
    if (name == "auto") return devices.empty() ? std::nullopt : std::optional(devices.front());

    // A number beyond the list may still be part of a name, as those of graphics cards are.
    if (const std::optional<uint32_t> index = parseIndex(wanted); index && *index < devices.size()) return devices[*index];
    if (!name.empty())
        for (const DeviceInfo& device : devices)
            if (lowered(device.name).find(name) != std::string::npos) return device;
    throw deviceError("no device '{}'; there are: {}; --device names one by index or part of its name", wanted, listNames());
}

Device::Device(const DeviceInfo& info, const DeviceOptions& options) : state_(std::make_unique<State>()) {
    const std::vector<vk::Physical>& devices = vk::physicalDevices();
    RAIG_CHECK_OP(info.index, <, devices.size());
    const vk::Physical& physical = devices[info.index];
    RAIG_CHECK(!options.rayQuery || physical.info.features.rayQuery);
    RAIG_CHECK(!options.graphics || physical.graphicsFamily.has_value());
    State& state = *state_;
    state.physical = physical.handle;
    state.info = physical.info;
    state.options = options;
    state.queueFamily = options.graphics ? *physical.graphicsFamily : physical.queueFamily;
    if (state.queueFamily != physical.queueFamily) state.info.limits.timestampNanoseconds = 0.0;  // it was the other's clock
    state.storageDescriptors = physical.storageDescriptors;
    state.texelDescriptors = physical.texelDescriptors;
    state.loadsTexel = options.loadsTexel.value_or(physical.info.prefersTexel);
    vkGetPhysicalDeviceMemoryProperties(physical.handle, &state.memory);
    state.staged = options.stagesTransfers || !canMapAll(physical.info, state.memory);
    {
        // SwiftShader starts its threads with the device, and can be told how many only by a file in the current folder.
        std::optional<FewerProcessors> fewer;
        if (physical.info.driver.starts_with("SwiftShader")) fewer.emplace();
        openQueue(state, physical.handle);
    }
    state.cacheKey = physical.cacheKey;
    if (options.diskCache) state.cacheFile = vk::cacheFile(physical.cacheKey);
    vk::openCache(state);
}

Device::~Device() = default;

Device::State::~State() {
    if (handle == VK_NULL_HANDLE) return;
    call.vkDeviceWaitIdle(handle);  // fails on a lost device, which may be taken down all the same
    transfers.reset();
    staging.reset();
    pipelines.clear();
    vk::closeCache(*this);
    call.vkDestroyCommandPool(handle, commandPool, nullptr);
    call.vkDestroyDevice(handle, nullptr);
}

const DeviceInfo& Device::info() const {
    return state_->info;
}

bool Device::loadsTexel() const {
    return state_->loadsTexel;
}

bool Device::draws() const {
    return state_->options.graphics;
}

uint64_t Device::largestBindingElements() const {
    const DeviceLimits& limits = state_->info.limits;
    uint64_t elements = loadsTexel() ? limits.texelBufferElements : limits.storageBufferBytes / 16;
    elements = std::min(elements, limits.allocationBytes / 16);
    // Kernels count elements with 32 bits, and a chunk's with one fewer.
    elements = std::min(elements, uint64_t{1} << 31);
    if (state_->options.largestBindingElements > 0) elements = std::min(elements, state_->options.largestBindingElements);
    return elements;
}

}  // namespace raig

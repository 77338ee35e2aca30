// What the devices are: their limits, features and drivers.
#include "device/vulkan.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace raig {

namespace {

/// Everything asked of a device in one go. Structures that the device's version does not know are left out of the chain:
/// SwiftShader complains on standard error about those.
struct Query {
    VkPhysicalDeviceProperties2 properties =
        vk::init<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    VkPhysicalDeviceSubgroupProperties subgroup =
        vk::init<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
    VkPhysicalDeviceMaintenance3Properties maintenance =
        vk::init<VkPhysicalDeviceMaintenance3Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES);
    VkPhysicalDeviceDriverProperties driver =
        vk::init<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
    VkPhysicalDeviceFloatControlsProperties floats =
        vk::init<VkPhysicalDeviceFloatControlsProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES);
    VkPhysicalDeviceFeatures2 features = vk::init<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
    VkPhysicalDeviceBufferDeviceAddressFeatures address = vk::init<VkPhysicalDeviceBufferDeviceAddressFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
    VkPhysicalDeviceScalarBlockLayoutFeatures scalar =
        vk::init<VkPhysicalDeviceScalarBlockLayoutFeatures>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES);
    VkPhysicalDeviceMemoryProperties memory{};

    Query(VkPhysicalDevice device, uint32_t apiVersion) {
        properties.pNext = &subgroup;
        subgroup.pNext = &maintenance;
        if (apiVersion >= VK_API_VERSION_1_2) {
            maintenance.pNext = &driver;
            driver.pNext = &floats;
            features.pNext = &address;
            address.pNext = &scalar;
        }
        vkGetPhysicalDeviceProperties2(device, &properties);
        vkGetPhysicalDeviceFeatures2(device, &features);
        vkGetPhysicalDeviceMemoryProperties(device, &memory);
    }
};

std::vector<VkQueueFamilyProperties> queueFamilies(VkPhysicalDevice device) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    families.resize(count);
    return families;
}

/// The first family that can do all of that: drivers put the one that can do everything first.
std::optional<uint32_t> findFamily(const std::vector<VkQueueFamilyProperties>& families, VkQueueFlags wanted) {
    for (uint32_t i = 0; i < families.size(); ++i)
        if (families[i].queueCount > 0 && (families[i].queueFlags & wanted) == wanted) return i;
    return std::nullopt;
}

bool hasExtension(VkPhysicalDevice device, const char* name) {
    uint32_t count = 0;
    if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) != VK_SUCCESS) return false;
    std::vector<VkExtensionProperties> extensions(count);
    if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()) != VK_SUCCESS) return false;
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

std::string describeVersion(uint32_t version) {
    return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                       VK_API_VERSION_PATCH(version));
}

std::string describeDriver(const Query& query) {
    const std::string name = query.driver.driverName, version = query.driver.driverInfo;
    return fmt::format("{} {}", name.empty() ? "driver" : name,
                       version.empty() ? describeVersion(query.properties.properties.driverVersion) : version);
}

DeviceType typeOf(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return DeviceType::discrete;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return DeviceType::integrated;
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return DeviceType::software;
        default:
            return DeviceType::virtualised;
    }
}

DeviceLimits limitsOf(const Query& query, const VkQueueFamilyProperties& family) {
    const VkPhysicalDeviceLimits& found = query.properties.properties.limits;
    DeviceLimits limits;
    limits.storageBufferBytes = found.maxStorageBufferRange;
    limits.texelBufferElements = found.maxTexelBufferElements;
    limits.allocationBytes = query.maintenance.maxMemoryAllocationSize;
    for (uint32_t i = 0; i < query.memory.memoryHeapCount; ++i)
        if (query.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            limits.memoryBytes = std::max<uint64_t>(limits.memoryBytes, query.memory.memoryHeaps[i].size);
    std::copy_n(found.maxComputeWorkGroupSize, 3, limits.workgroupSize.begin());
    limits.workgroupInvocations = found.maxComputeWorkGroupInvocations;
    std::copy_n(found.maxComputeWorkGroupCount, 3, limits.workgroupCount.begin());
    limits.sharedMemoryBytes = found.maxComputeSharedMemorySize;
    limits.pushConstantBytes = found.maxPushConstantsSize;
    limits.framebufferSide = std::min({found.maxFramebufferWidth, found.maxFramebufferHeight, found.maxImageDimension2D,
                                       found.maxViewportDimensions[0], found.maxViewportDimensions[1]});
    limits.subgroupSize = query.subgroup.subgroupSize;
    // Queues whose clock has fewer than 64 bits wrap around; one that wraps within a dispatch is no clock.
    if (family.timestampValidBits >= 36) limits.timestampNanoseconds = found.timestampPeriod;
    return limits;
}

DeviceFeatures featuresOf(const Query& query, const std::vector<VkQueueFamilyProperties>& families, uint32_t family) {
    DeviceFeatures features;
    features.float64 = query.features.features.shaderFloat64;
    features.int64 = query.features.features.shaderInt64;
    features.int16 = query.features.features.shaderInt16;
    features.bufferDeviceAddress = query.address.bufferDeviceAddress;
    features.scalarBlockLayout = query.scalar.scalarBlockLayout;
    features.timestamps = families[family].timestampValidBits >= 36;
    features.keepsDenormals = query.floats.shaderDenormPreserveFloat32;
    features.flushesDenormals = query.floats.shaderDenormFlushToZeroFloat32;
    features.keepsNan = query.floats.shaderSignedZeroInfNanPreserveFloat32;
    if (query.subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) {
        const char* names[] = {"basic", "vote", "arithmetic", "ballot", "shuffle", "shuffle relative", "clustered", "quad"};
        for (uint32_t bit = 0; bit < std::size(names); ++bit)
            if (query.subgroup.supportedOperations & (1u << bit)) features.subgroupOperations.emplace_back(names[bit]);
    }
    return features;
}

std::string cacheKeyOf(const Query& query, const DeviceInfo& info) {
    const VkPhysicalDeviceProperties& found = query.properties.properties;
    std::string key =
        fmt::format("{}|{}|{}|{}|{}|", info.name, info.driver, found.vendorID, found.deviceID, found.driverVersion);
    for (const uint8_t byte : found.pipelineCacheUUID) key += fmt::format("{:02x}", byte);
    // Mesa's llvmpipe does not tell its vector width in its UUID, though its machine code depends on it.
    const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
    return key + "|" + (width ? width : "");
}

}  // namespace

namespace vk {

std::optional<Physical> examine(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(device, &properties);
    const std::vector<VkQueueFamilyProperties> families = queueFamilies(device);
    const std::optional<uint32_t> family = findFamily(families, VK_QUEUE_COMPUTE_BIT);
    if (properties.apiVersion < VK_API_VERSION_1_1 || !family) return std::nullopt;

    const Query query(device, properties.apiVersion);
    Physical found;
    found.handle = device;
    found.queueFamily = *family;
    found.graphicsFamily = findFamily(families, VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT);
    // A binding's descriptors also count towards the limit on all resources of a stage; every device here allows more.
    found.storageDescriptors = properties.limits.maxPerStageDescriptorStorageBuffers;
    found.texelDescriptors = properties.limits.maxPerStageDescriptorSampledImages;
    found.info.name = properties.deviceName;
    found.info.driver = describeDriver(query);
    found.info.type = typeOf(properties.deviceType);
    found.info.apiVersion = describeVersion(properties.apiVersion);
    found.info.limits = limitsOf(query, families[*family]);
    found.info.features = featuresOf(query, families, *family);
    found.info.features.graphics = found.graphicsFamily.has_value();
    found.info.features.rayQuery = hasExtension(device, VK_KHR_RAY_QUERY_EXTENSION_NAME) &&
                                   hasExtension(device, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) &&
                                   hasExtension(device, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME) &&
                                   query.address.bufferDeviceAddress && properties.apiVersion >= VK_API_VERSION_1_2;
    found.info.prefersTexel =
        query.driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE && found.info.limits.texelBufferElements >= (uint64_t{1} << 24);
    found.cacheKey = cacheKeyOf(query, found.info);
    return found;
}

const std::vector<Physical>& physicalDevices() {
    static const std::vector<Physical> devices = [] {
        std::vector<Physical> list;
        uint32_t count = 0;
        if (instance() == VK_NULL_HANDLE || vkEnumeratePhysicalDevices(instance(), &count, nullptr) != VK_SUCCESS)
            return list;
        std::vector<VkPhysicalDevice> handles(count);
        if (vkEnumeratePhysicalDevices(instance(), &count, handles.data()) < VK_SUCCESS) return list;
        for (uint32_t i = 0; i < count; ++i)
            if (std::optional<Physical> found = examine(handles[i])) list.push_back(*std::move(found));

        // llvmpipe is the software device that large scenes fit and that compiles to wide vectors.
        const auto rank = [](const Physical& p) {
            return 2 * static_cast<int>(p.info.type) + (p.info.name.find("llvmpipe") == std::string::npos ? 1 : 0);
        };
        std::stable_sort(list.begin(), list.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
        for (uint32_t i = 0; i < list.size(); ++i) list[i].info.index = i;
        return list;
    }();
    return devices;
}

}  // namespace vk

}  // namespace raig

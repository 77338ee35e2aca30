/// The Vulkan objects behind Device, Buffer, Kernel and Commands. For this folder alone.
#pragma once

#include "base/error.hpp"
#include "device/commands.hpp"

#include <volk.h>

#include <filesystem>
#include <tuple>

namespace raig::vk {

/// Throws for any result that is not a success: limitError for want of memory, deviceError for all else. `what` completes
/// the sentence "cannot ...".
void check(VkResult result, const char* what);

/// A Vulkan structure, all zero but for its type.
template <class T>
T init(VkStructureType type) {
    T value{};
    value.sType = type;
    return value;
}

/// A device as the loader lists it, and what was found about it.
struct Physical {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    std::optional<uint32_t> graphicsFamily;  ///< draws and computes; where there is one
    std::string cacheKey;             ///< changes whenever compiled pipelines would
    uint32_t storageDescriptors = 0;  ///< that one kernel may have
    uint32_t texelDescriptors = 0;
    DeviceInfo info;
};

/// Of all devices, in the order of listDevices().
const std::vector<Physical>& physicalDevices();

/// Nothing if the device lacks Vulkan 1.1 or a compute queue.
std::optional<Physical> examine(VkPhysicalDevice device);

/// The instance: made when first asked for, kept until the process ends. Null if there is no loader or no driver.
VkInstance instance();

struct BufferState {
    Device::State* device = nullptr;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkBufferView view = VK_NULL_HANDLE;  ///< RGBA32_UINT, of texel buffers
    std::byte* mapped = nullptr;         ///< null where transfers are staged
    uint64_t bytes = 0;
    bool storage = false;

    BufferState() = default;
    BufferState(const BufferState&) = delete;
    BufferState& operator=(const BufferState&) = delete;
    ~BufferState();
};

enum class Memory { device, staging };
std::shared_ptr<BufferState> makeBuffer(Device::State& device, uint64_t bytes, VkBufferUsageFlags usage, Memory memory);

/// A compiled kernel and its layouts.
struct Pipeline {
    Device::State* device = nullptr;
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline handle = VK_NULL_HANDLE;

    Pipeline() = default;
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;
    ~Pipeline();
};

/// What a pipeline is made from: the kernel's name, its specialization constants, its SPIR-V.
using PipelineKey = std::tuple<std::string, Constants, std::vector<uint32_t>>;

/// What the commands so far wrote is seen by those that follow, and by the host.
void barrier(const VolkDeviceTable& call, VkCommandBuffer commands);
void barrierToHost(const VolkDeviceTable& call, VkCommandBuffer commands);

/// Waits until `fence` is signalled, however long the work takes; says so when that is long. Throws if the device is lost.
void waitFor(Device::State& device, VkFence fence);

/// What waits, records and runs: a command buffer and its fence.
struct Recorder {
    explicit Recorder(Device::State& device);
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    void begin();
    void submit();
    void wait();

    Device::State& device;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
};

}  // namespace raig::vk

namespace raig {

struct Device::State {
    DeviceInfo info;
    DeviceOptions options;
    bool loadsTexel = false;
    bool staged = false;  ///< buffers are not mapped: transfers go through `staging`
    uint32_t queueFamily = 0;
    uint32_t storageDescriptors = 0;
    uint32_t texelDescriptors = 0;

    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice handle = VK_NULL_HANDLE;
    VolkDeviceTable call{};
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool commandPool = VK_NULL_HANDLE;
    VkPhysicalDeviceMemoryProperties memory{};
    VkPipelineCache cache = VK_NULL_HANDLE;
    std::filesystem::path cacheFile;  ///< empty: none
    std::string cacheKey;
    uint64_t cacheHash = 0;  ///< of what was read from the file
    bool cacheGrew = false;

    /// Kernels made so far: the same one again costs nothing. Kept, as whoever traces much makes the same few again and
    /// again.
    std::map<vk::PipelineKey, std::unique_ptr<vk::Pipeline>> pipelines;

    std::shared_ptr<vk::BufferState> staging;  ///< made when first needed
    std::unique_ptr<vk::Recorder> transfers;

    ~State();
};

struct Kernel::State {
    struct Bound {
        std::vector<std::weak_ptr<vk::BufferState>> buffers;  ///< one a descriptor
    };

    Device::State* device = nullptr;
    std::string name;
    KernelInterface interface;
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;  ///< these three are the device's
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    uint32_t storageDescriptors = 0;
    uint32_t texelDescriptors = 0;
    std::map<uint32_t, Bound> bound;
};

}  // namespace raig

/// Vulkan devices: which there are, which one a person means, and one opened for compute.
///
/// Core Vulkan 1.1 compute is all that is asked of a device: no extension, no optional feature, no surface. What else it has
/// is found and reported. Nothing is linked: volk loads the loader, and where there is none, there are no devices.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raig {

enum class DeviceType { discrete, integrated, virtualised, software };

/// "hardware" or "software", as the `devices` command says it.
const char* describe(DeviceType type);

struct DeviceLimits {
    uint64_t storageBufferBytes = 0;   ///< of one binding
    uint64_t texelBufferElements = 0;  ///< of one binding
    uint64_t allocationBytes = 0;      ///< of one allocation
    uint64_t memoryBytes = 0;          ///< of the heap that buffers live in
    std::array<uint32_t, 3> workgroupSize{};
    uint32_t workgroupInvocations = 0;
    std::array<uint32_t, 3> workgroupCount{};
    uint32_t sharedMemoryBytes = 0;
    uint32_t pushConstantBytes = 0;
    uint32_t framebufferSide = 0;      ///< of what can be drawn into, each way
    uint32_t subgroupSize = 0;
    double timestampNanoseconds = 0.0;  ///< of one tick of the device's clock; 0: it has none
};

/// What was found, whether used or not. Only what core 1.1 compute needs is enabled.
struct DeviceFeatures {
    bool float64 = false;
    bool int64 = false;
    bool int16 = false;
    bool bufferDeviceAddress = false;
    bool scalarBlockLayout = false;
    bool timestamps = false;
    bool rayQuery = false;                        ///< VK_KHR_ray_query, and what it needs
    bool graphics = false;                        ///< a queue that draws and computes
    bool keepsDenormals = false;                  ///< float controls: can be told to keep them (32 bit)
    bool flushesDenormals = false;                ///< float controls: can be told to flush them (32 bit)
    bool keepsNan = false;                        ///< float controls: signed zero, infinity and NaN preserved (32 bit)
    std::vector<std::string> subgroupOperations;  ///< in compute: "basic", "vote", "ballot", ...
};

struct DeviceInfo {
    uint32_t index = 0;  ///< in listDevices()
    std::string name;
    std::string driver;  ///< name and version
    DeviceType type = DeviceType::software;
    std::string apiVersion;
    DeviceLimits limits;
    DeviceFeatures features;
    /// Large read-only arrays load faster as texel buffers: on Mesa's llvmpipe 2-3 times (measured with 22.3).
    bool prefersTexel = false;
};

/// All devices with a compute queue and Vulkan 1.1, best first: discrete, integrated, virtual, llvmpipe, other software.
/// Empty if there is no Vulkan loader or no device: no error. Mesa's drivers are found by the loader, SwiftShader where
/// Chromium's packages put it, unless the user chose drivers with the loader's own environment variables.
/// The first call costs what loading the drivers costs; later ones nothing.
const std::vector<DeviceInfo>& listDevices();

/// The device meant by `--device`; nothing means the CPU path. "auto": the first of listDevices(), or the CPU path if none;
/// "cpu": the CPU path; a number: that index; else the first device whose name contains `wanted`, in any case.
/// Throws deviceError, which lists the devices there are.
std::optional<DeviceInfo> chooseDevice(std::string_view wanted);

struct DeviceOptions {
    std::optional<bool> loadsTexel = std::nullopt;  ///< instead of DeviceInfo::prefersTexel, where the device can
    uint64_t largestBindingElements =
        0;                         ///< pretends one binding of a BigArray holds no more than these (tests); 0: as it is
    bool stagesTransfers = false;  ///< copies through a staging buffer even where memory could be mapped (tests)
    bool rayQuery = false;         ///< open it with DeviceFeatures::rayQuery, which must be there; buffers are made for it
    bool graphics = false;  ///< its queue draws, too (device/raster.hpp): with DeviceFeatures::graphics, which must be there
    bool diskCache = true;         ///< keep compiled pipelines in the user's cache folder
};

/// An open device with one queue, which computes. It must outlive what was made on it. Not for use by two threads at once.
class Device {
public:
    /// Throws deviceError if the device cannot be opened.
    explicit Device(const DeviceInfo& info, const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceInfo& info() const;
    /// The form of kernel to use: "NAME_texel" if true, "NAME_storage" if not. BigArrays are made to suit.
    bool loadsTexel() const;
    /// True if it was opened with DeviceOptions::graphics.
    bool draws() const;
    /// The elements of 16 bytes that one binding of a BigArray holds at most, in the form that loadsTexel() says.
    uint64_t largestBindingElements() const;

    struct State;  ///< the Vulkan objects: device/vulkan.hpp
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

/// What the validation layers have said so far, in this process; always empty unless RAIG_VALIDATION=1 is in the
/// environment when the first device is listed.
std::vector<std::string> validationMessages();

/// True if validation was asked for and its layer is there.
bool validationActive();

}  // namespace raig

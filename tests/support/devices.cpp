#include "support/devices.hpp"

#include <algorithm>
#include <cctype>

#ifdef __SANITIZE_ADDRESS__
// The validation layer keeps what it knows of a device after the device has gone (1.3.239); raig's own leaks still show.
extern "C" const char* __lsan_default_suppressions() { return "leak:libVkLayer_khronos_validation.so\n"; }
#endif

namespace raig {

std::vector<std::string> devicesToTest() {
    std::vector<std::string> names{"llvmpipe", "SwiftShader"};
    for (const DeviceInfo& device : listDevices())
        if (device.type != DeviceType::software) names.push_back(device.name);
    std::sort(names.begin() + 2, names.end());
    names.erase(std::unique(names.begin() + 2, names.end()), names.end());
    return names;
}

std::optional<DeviceInfo> findDevice(const std::string& partOfName) {
    for (const DeviceInfo& device : listDevices())
        if (device.name.find(partOfName) != std::string::npos) return device;
    return std::nullopt;
}

void OnEveryDevice::SetUp() {
    const std::optional<DeviceInfo> found = findDevice(GetParam());
    if (!found) GTEST_SKIP() << "no Vulkan device named " << GetParam() << " here";
    info = *found;
}

void OnEveryDevice::TearDown() {
    for (const std::string& message : validationMessages()) ADD_FAILURE() << message;
}

std::string testName(const testing::TestParamInfo<std::string>& device) {
    std::string name = device.param;
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name;
}

}  // namespace raig

/// The Vulkan devices that tests run on.
#pragma once

#include "device/device.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace raig {

/// Parts of device names: lavapipe's and SwiftShader's, whether they are there or not, and those of all hardware found.
std::vector<std::string> devicesToTest();

/// The device of that name, if there is one.
std::optional<DeviceInfo> findDevice(const std::string& partOfName);

/// A test that runs on every device of devicesToTest(), and skips by name those that are not there. Fails if validation,
/// where active, has anything to say (see RAIG_VALIDATION in device/device.hpp).
class OnEveryDevice : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override;
    void TearDown() override;

    DeviceInfo info;  ///< of the device
};

/// A device's name as a part of a test's name.
std::string testName(const testing::TestParamInfo<std::string>& device);

}  // namespace raig

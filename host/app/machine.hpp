/// What is told of the machine beside what was measured on it.
#pragma once

#include "base/threads.hpp"
#include "device/arithmetic.hpp"
#include "device/device.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace raig {

/// As the system calls it; "unknown" where it does not say.
std::string processorName();

/// The commit that the program was built of: its full hash, with "-dirty" behind it where sources were not as committed;
/// "unknown" where git could not tell.
std::string_view commitId();

struct MeasuredArithmetic {
    std::optional<Arithmetic> arithmetic;
    std::string why;  ///< there is none
};

/// A device that fails should not hide what else there is: why it does is told.
MeasuredArithmetic measureArithmetic(Device& device);
MeasuredArithmetic measureArithmetic(const DeviceInfo& info);

nlohmann::ordered_json toJson(const MeasuredArithmetic& measured);

/// In words.
std::string describe(const MeasuredArithmetic& measured);

}  // namespace raig

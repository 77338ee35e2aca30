#include "app/machine.hpp"

#include "base/error.hpp"
#include "rays/kernels.hpp"

#include <fmt/ranges.h>

#include <fstream>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Arithmetic& found) {
    return {{"ieee", found.ieee()},
            {"samples", found.samples},
            {"add_exact", found.addExact},
            {"sub_exact", found.subExact},
            {"mul_exact", found.mulExact},
            {"div_exact", found.divExact},
            {"sqrt_exact", found.sqrtExact},
            {"denormals", found.denormals},
            {"contraction", found.contraction},
            {"precise_contraction", found.preciseContraction},
            {"fma", found.fma},
            {"min_max_nan", found.minMaxNan},
            {"division_by_zero", found.divisionByZero},
            {"int_to_float_exact", found.intToFloatExact},
            {"uint_to_float_exact", found.uintToFloatExact},
            {"float_to_int_exact", found.floatToIntExact}};
}

std::string describe(const Arithmetic& found) {
    std::vector<std::string> inexact;
    for (const auto& [exact, name] :
         {std::pair(found.addExact, "+"), std::pair(found.subExact, "-"), std::pair(found.mulExact, "*"),
          std::pair(found.divExact, "/"), std::pair(found.sqrtExact, "sqrt"),
          std::pair(found.intToFloatExact, "int to float"), std::pair(found.uintToFloatExact, "uint to float"),
          std::pair(found.floatToIntExact, "float to int")})
        if (!exact) inexact.emplace_back(name);
    return fmt::format("{}; denormals {}; a * b + c fused: {}, where precise: {}; fma {}; min and max of a NaN: {}",
                       inexact.empty() ? "as IEEE 754" : fmt::format("as IEEE 754 but for {}", fmt::join(inexact, ", ")),
                       found.denormals, found.contraction == "none" ? "no" : found.contraction,
                       found.preciseContraction == "none" ? "no" : found.preciseContraction, found.fma, found.minMaxNan);
}

}  // namespace

std::string processorName() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name") && line.find(": ") != line.npos) return line.substr(line.find(": ") + 2);
    return "unknown";
}

MeasuredArithmetic measureArithmetic(Device& device) {
    try {
        return {measureArithmetic(device, findKernel("selftest_storage").value()), ""};
    } catch (const Error& error) {
        return {std::nullopt, error.what()};
    }
}

MeasuredArithmetic measureArithmetic(const DeviceInfo& info) {
    try {
        Device device(info);
        return measureArithmetic(device);
    } catch (const Error& error) {
        return {std::nullopt, error.what()};
    }
}

Json toJson(const MeasuredArithmetic& measured) {
    return measured.arithmetic ? toJson(*measured.arithmetic) : Json{{"error", measured.why}};
}

std::string describe(const MeasuredArithmetic& measured) {
    return measured.arithmetic ? describe(*measured.arithmetic) : "not measured: " + measured.why;
}

}  // namespace raig

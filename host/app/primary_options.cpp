#include "app/primary_options.hpp"

#include "base/error.hpp"

#include <CLI/CLI.hpp>

namespace raig {

void addPrimaryOptions(CLI::App& command, Options& options) {
    const auto parse = [&options](const std::string& text) {
        if (text != "ray" && text != "raster") throw usageError("--primary {}: ray or raster is wanted", text);
        options.primary = text == "ray" ? Primary::ray : Primary::raster;
    };
    command
        .add_option_function<std::string>(
            "--primary", parse,
            "how camera rays find what they meet: ray, traced; or raster: the device draws the "
            "scene first, which tells rays where to look; pictures are the same "
            "(default: ray)")
        ->type_name("HOW");
}

void checkPrimary(const Options& options, const std::optional<DeviceInfo>& device) {
    if (options.primary == Primary::ray) return;
    if (!device && options.device == "cpu")
        throw usageError("--primary raster: --device cpu has no graphics queue; name a device that has one, or leave "
                         "--primary out");
    if (!device) throw deviceError("--primary raster: there is no Vulkan device to draw on; leave --primary out");
    if (!device->features.graphics)
        throw deviceError("--primary raster: device '{}' has no queue that draws and computes; --device names another, or "
                          "leave --primary out",
                          device->name);
}

}  // namespace raig

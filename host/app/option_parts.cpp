#include "app/option_parts.hpp"

#include "base/error.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <limits>

namespace raig {

std::optional<uint32_t> wholeNumber(std::string_view text, uint32_t low, uint32_t high) {
    const std::optional<uint32_t> value = numberOf<uint32_t>(text);
    return value && *value >= low && *value <= high ? value : std::nullopt;
}

void addWholeNumber(CLI::App& app, const std::string& name, uint32_t& value, uint32_t low, uint32_t high,
                    const std::string& description) {
    const auto parse = [&value, name, low, high](const std::string& text) {
        const std::optional<uint32_t> number = wholeNumber(text, low, high);
        if (!number) throw usageError("{} {}: a whole number from {} to {} is wanted", name, text, low, high);
        value = *number;
    };
    app.add_option_function<std::string>(name, parse, description)->type_name("N");
}

CLI::Option* addInput(CLI::App& app, Options& options, const std::string& name, const std::string& description) {
    const auto append = [&options](const std::string& text) { options.inputs.emplace_back(text); };
    return app.add_option_function<std::string>(name, append, description)->type_name("FILE");
}

void addPictureFile(CLI::App& app, Options& options, const std::string& description, bool required) {
    const auto parse = [&options](const std::string& text) {
        std::string ending = std::filesystem::path(text).extension().string();
        std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
        if (ending != ".png" && ending != ".hdr" && ending != ".exr" && ending != ".pfm")
            throw usageError("--output {}: a file ending in .png, .hdr, .exr or .pfm is wanted", text);
        options.output = text;
    };
    app.add_option_function<std::string>("-o,--output", parse, description)->type_name("FILE")->required(required);
}

void addSeed(CLI::App& app, Options& options) {
    addWholeNumber(app, "--seed", options.seed, 0, std::numeric_limits<uint32_t>::max(),
                   "of the random numbers (default: 0)");
}

void addCommon(CLI::App& app, Options& options) {
    app.add_option("--device", options.device, "auto, cpu, an INDEX of `raig devices`, or a part of a NAME (default: auto)")
        ->type_name("DEVICE");
    addWholeNumber(app, "--threads", options.threads, 0, 1024, "processor threads, 0: one a core (default: 0)");
    app.add_flag("--json", options.json, "print one JSON document on standard output");
    app.add_flag("--quiet", options.quiet, "print no remarks and no progress");
}

}  // namespace raig

#include "app/aov_options.hpp"

#include "base/error.hpp"
#include "image/image.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>

namespace raig {

namespace {

std::string allNames() {
    std::vector<std::string_view> names;
    for (const AovType& type : aovTypes()) names.push_back(type.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

Aov parseAov(const char* option, const std::string& given, std::string_view name) {
    const std::optional<Aov> aov = findAov(name);
    if (!aov) throw usageError("{} {}: there is no AOV '{}'; there are {}", option, given, name, allNames());
    return *aov;
}

/// "depth,normal". What is named twice is written once.
std::vector<Aov> parseAovs(const std::string& text) {
    std::vector<Aov> aovs;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        const Aov aov = parseAov("--aov", text, std::string_view(text).substr(begin, end - begin));
        if (std::ranges::find(aovs, aov) == aovs.end()) aovs.push_back(aov);
        begin = end + 1;
    }
    return aovs;
}

}  // namespace

void addAovOptions(CLI::App& command, Options& options) {
    command
        .add_option_function<std::string>(
            "--aov", [&options](const std::string& text) { options.aovs = parseAovs(text); },
            fmt::format(
                "write these of each pixel, too, as layers of an .exr, or beside another picture to out.NAME.exr: {}",
                allNames()))
        ->type_name("NAME,...");
    command
        .add_option_function<std::string>(
            "--view", [&options](const std::string& text) { options.view = parseAov("--view", text, text); },
            "the picture shows one of these in false colours, with a legend where it is a number, instead of light")
        ->type_name("NAME");
}

std::string aovExamples() {
    return "  raig render scene.glb -o out.exr --aov depth,normal,primitive\n"
           "  raig render scene.glb -o cost.png --view cost\n";
}

std::string aovHelp() {
    return "Of the ray through a pixel's centre: depth along it, position, normal, uv, albedo, and the numbers of the\n"
           "primitive, instance and material; where it meets nothing depth is inf, numbers are 0xffffffff, the rest 0.\n"
           "Of all of a pixel's rays: samples, level of the deepest, discarded weight, and cost: the nodes and primitives\n"
           "looked at, which takes some more time. Layers have channels depth.Z, position.X, ..., primitive.ID, cost.N.";
}

std::vector<std::filesystem::path> aovFiles(const Options& options) {
    std::vector<std::filesystem::path> files;
    if (options.aovs.empty() || pictureFormat(options.output) == PictureFormat::exr) return files;
    for (const Aov aov : options.aovs) {
        std::filesystem::path file = options.output;
        files.push_back(file.replace_extension(fmt::format("{}.exr", typeOf(aov).name)));
    }
    return files;
}

}  // namespace raig

#include "app/structure_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>

namespace raig {

namespace {

const std::vector<std::string> structureNames = {
#define RAIG_STRUCTURE(name) #name,
#include "structures/registry.def"
#undef RAIG_STRUCTURE
};

void addInstances(CLI::App& app, Options& options) {
    const auto parse = [&options](const std::string& text) {
        if (text != "auto" && text != "keep" && text != "flatten")
            throw usageError("--instances {}: auto, keep or flatten is wanted", text);
        options.instances = text;
    };
    app.add_option_function<std::string>("--instances", parse,
                                         "keep meshes that stand in several places once, or flatten: write them all out "
                                         "(default: auto, keep where that halves the triangles); hits are the same")
        ->type_name("HOW");
}

}  // namespace

void addMemoryBudget(CLI::App& app, Options& options) {
    const auto parseBudget = [&options](const std::string& text) {
        const std::optional<uint32_t> mebibytes = wholeNumber(text, 1, 1u << 20);
        if (!mebibytes) throw usageError("--memory-budget {}: a whole number of MiB from 1 to 1048576 is wanted", text);
        options.buildParams.memoryBudget = uint64_t{*mebibytes} << 20;
    };
    app.add_option_function<std::string>("--memory-budget", parseBudget,
                                         "most MiB of a structure: builders stop subdividing before it (default: 4096)")
        ->type_name("MIB");
}

void addStructure(CLI::App& app, Options& options, const std::string& more, const std::string& byDefault) {
    const std::string moreName = more.substr(0, more.find(','));
    const auto parse = [&options, moreName](const std::string& text) {
        if (text != moreName && std::find(structureNames.begin(), structureNames.end(), text) == structureNames.end())
            throw usageError("--accel {}: there is no such structure; there are {}, {}", text,
                             fmt::join(structureNames, ", "), moreName);
        options.accel = text;
        options.accelGiven = true;
    };
    app.add_option_function<std::string>(
           "--accel", parse,
           fmt::format("acceleration structure: {}, {} (default: {})", fmt::join(structureNames, ", "), more, byDefault))
        ->type_name("NAME");
    BuildParams& params = options.buildParams;
    const bool isAuto = more.starts_with("auto");  // else each structure is taken as it is
    const char* const walk = isAuto ? "auto: bvh by trail on the CPU, in large scenes as is fastest on the device"
                                    : "the structure's own";
    app.add_option("--walk", params.walk, fmt::format("how the structure is walked (default: {})", walk))
        ->type_name("NAME");
    app.add_option("--build", params.build, "how the structure is built (default: the structure's own)")->type_name("NAME");
    app.add_option("--bound", params.bound, "bounding volume of bvh: aabb, sphere, obb, kdop (default: aabb)")
        ->type_name("NAME");
    const auto parseChoice = [](const std::string& name, uint32_t& value, std::vector<uint32_t> choices) {
        return [name, &value, choices](const std::string& text) {
            const std::optional<uint32_t> number = numberOf<uint32_t>(text);
            if (!number || std::find(choices.begin(), choices.end(), *number) == choices.end())
                throw usageError("{} {}: one of {} is wanted", name, text, fmt::join(choices, ", "));
            value = *number;
        };
    };
    const char* const arity = isAuto ? "4, unless --walk auto picks 2" : "4";
    app.add_option_function<std::string>("--arity", parseChoice("--arity", params.arity, {2, 4, 8}),
                                         fmt::format("most children of a node of bvh: 2, 4 or 8 (default: {})", arity))
        ->type_name("N");
    app.add_option_function<std::string>("--precision", parseChoice("--precision", params.precision, {32, 16, 8}),
                                         "bits of a plane of bvh's boxes: 32, 16 or 8 (default: as suits the scene)")
        ->type_name("BITS");
    addWholeNumber(app, "--max-leaf", params.maxLeaf, 1, 255, "most primitives a leaf should hold, MAX_OBJ");
    addWholeNumber(app, "--max-tree-depth", params.maxTreeDepth, 1, 64, "most levels of a tree, MAX_DEPTH");
    addWholeNumber(app, "--levels", params.levels, 1, 2, "levels of a grid");
    const auto parseDensity = [&params](const std::string& text) {
        const std::optional<double> value = numberOf<double>(text);
        if (!value || !(*value >= 1e-3 && *value <= 1e3))
            throw usageError("--grid-density {}: a number from 0.001 to 1000 is wanted", text);
        params.gridDensity = static_cast<float>(*value);
    };
    app.add_option_function<std::string>("--grid-density", parseDensity, "cells of a grid a primitive")->type_name("X");
    addMemoryBudget(app, options);
    if (isAuto) {
        addInstances(app, options);
        CLI::Option* const save =
            app.add_option("--save-structure", options.saveStructure, "write the structure to this file");
        app.add_option("--load-structure", options.loadStructure,
                       "read the structure from such a file instead of building it; instances are kept as they are there")
            ->type_name("FILE")
            ->excludes(save->type_name("FILE"));
    }
    addSeed(app, options);
}

}  // namespace raig

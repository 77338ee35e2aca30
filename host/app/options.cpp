#include "app/options.hpp"

#include "app/animation_options.hpp"
#include "app/aov_options.hpp"
#include "app/chart_options.hpp"
#include "app/compare_options.hpp"
#include "app/environment_options.hpp"
#include "app/integrator_options.hpp"
#include "app/primary_options.hpp"
#include "app/sampling_options.hpp"
#include "app/tone_options.hpp"
#include "app/view_options.hpp"
#include "app/written_files.hpp"
#include "base/error.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>

namespace raig {

namespace {

constexpr uint32_t largest = std::numeric_limits<uint32_t>::max();

const std::vector<std::string> structureNames = {
#define RAIG_STRUCTURE(name) #name,
#include "structures/registry.def"
#undef RAIG_STRUCTURE
};

/// The whole text as one number, or nothing. No blanks, no plus sign, no trailing characters.
template <class Number>
std::optional<Number> numberOf(std::string_view text) {
    Number value{};
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<uint32_t> wholeNumber(std::string_view text, uint32_t low, uint32_t high) {
    const std::optional<uint32_t> value = numberOf<uint32_t>(text);
    return value && *value >= low && *value <= high ? value : std::nullopt;
}

/// "0.25" or "1/4", in [0, 1].
std::optional<double> fraction(std::string_view text) {
    const size_t slash = text.find('/');
    const std::optional<double> over = numberOf<double>(text.substr(0, slash));
    const std::optional<double> under = slash == text.npos ? 1.0 : numberOf<double>(text.substr(slash + 1));
    if (!over || !under) return std::nullopt;
    const double value = *over / *under;
    return value >= 0.0 && value <= 1.0 ? std::optional(value) : std::nullopt;  // NaN is neither
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

/// A file named by its place on the command line.
CLI::Option* addInput(CLI::App& app, Options& options, const std::string& name, const std::string& description) {
    const auto append = [&options](const std::string& text) { options.inputs.emplace_back(text); };
    return app.add_option_function<std::string>(name, append, description)->type_name("FILE");
}

void addCommon(CLI::App& app, Options& options) {
    app.add_option("--device", options.device, "auto, cpu, an INDEX of `raig devices`, or a part of a NAME (default: auto)")
        ->type_name("DEVICE");
    addWholeNumber(app, "--threads", options.threads, 0, 1024, "processor threads, 0: one a core (default: 0)");
    app.add_flag("--json", options.json, "print one JSON document on standard output");
    app.add_flag("--quiet", options.quiet, "print no remarks and no progress");
}

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

/// `more` stands for other than one structure: auto, or all.
void addStructure(CLI::App& app, Options& options, const std::string& more = "auto, which picks one for the scene",
                  const std::string& byDefault = "bvh") {
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
    addWholeNumber(app, "--seed", options.seed, 0, largest, "of the random numbers (default: 0)");
}

/// `side` is the command's default size, in pixels both ways.
void addPicture(CLI::App& app, Options& options, uint32_t side) {
    const auto parseContribution = [&options](const std::string& text) {
        const std::optional<double> value = fraction(text);
        if (!value) throw usageError("--min-contribution {}: a number or fraction from 0 to 1 is wanted, as 1/512", text);
        options.minContribution = *value;
    };
    addViewOptions(app, options, side);
    addEnvironmentOptions(app, options);
    addWholeNumber(app, "--max-depth", options.maxDepth, 0, 64,
                   "levels of reflection and refraction, NIVELL_MAX (default: 8)");
    app.add_option_function<std::string>("--min-contribution", parseContribution,
                                         "what contributes less is not traced, MIN_CONTRIB (default: 1/512)")
        ->type_name("X");
    addWholeNumber(app, "--spp", options.samples, 1, 65536, "samples a pixel");
    addFilterOption(app, options);
    addIntegratorOptions(app, options);
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

void addRender(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("render", "Render a picture of a scene");
    command.callback([&options] { options.command = Command::render; });
    addInput(command, options, "scene", "a .gltf, .glb, .obj, .ply or .stl file")->required();
    addPictureFile(command, options, "the picture: .png, .hdr, .exr or .pfm", true);
    addPicture(command, options, 512);
    addMomentOptions(command, options);
    addFrameOptions(command, options);
    addSamplingOptions(command, options);
    addPrimaryOptions(command, options);
    addAovOptions(command, options);
    addToneOptions(command, options);
    command.add_flag("-v,--verbose", options.verbose,
                     "say what is left out as the scene has nothing of it, and what that saves");
    addStructure(command, options);
    addCommon(command, options);
    command.footer("Examples:\n"
                   "  raig render scene.glb -o out.png\n"
                   "  raig render scene.obj -o out.exr --size 1280x720 --spp 16 --device cpu\n"
                   "  raig render scene.glb -o out.png --adaptive 0.01\n"
                   "  raig render scene.glb -o out.png --time 10\n"
                   "  raig render glass.glb -o out.png --max-depth 20 --min-contribution 1/4096\n"
                   "  raig render bunny.ply -o out.png --eye 1,2,3 --fov 30\n"
                   "  raig render room.glb -o part.png --size 4096x4096 --crop 1024,2048,256,256\n"
                   "  raig render room.glb -o sharp.png --aperture 0.05 --focus 2.5 --spp 64\n"
                   "  raig render room.glb -o out.png --exposure auto --tonemap aces\n"
                   "  raig render room.glb -o out.png --primary raster\n"
                   "  raig render bunny.ply -o out.png --environment field.hdr --environment-rotate 90\n"
                   "  raig render walk.glb -o walk.png --frames 0:47 --fps 24\n"
                   "  raig render room.glb -o lit.png --integrator path --spp 256\n"
                   "  raig render bunny.ply -o clay.png --integrator ao --spp 64\n" +
                   aovExamples() + viewHelp + integratorHelp + samplingHelp + animationHelp + environmentHelp +
                   toneHelp + aovHelp());
}

void addTrace(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("trace", "Trace a batch of rays");
    command.callback([&options] { options.command = Command::trace; });
    addInput(command, options, "scene", "a .gltf, .glb, .obj, .ply or .stl file")->required();
    command.add_option("--rays", options.rays, "NumPy file of float32 [N,8]: ox oy oz tmin dx dy dz tmax")
        ->type_name("FILE")->required();
    command.add_option("--hits", options.hits,
                       "NumPy file to write: t u v float32, primitive instance uint32 (0xffffffff: none)")
        ->type_name("FILE")->required();
    const auto parseQuery = [&options](const std::string& text) {
        if (text != "closest" && text != "any") throw usageError("--query {}: closest or any is wanted", text);
        options.query = text == "any" ? Query::any : Query::closest;
    };
    command.add_option_function<std::string>("--query", parseQuery, "closest or any (default: closest)")->type_name("QUERY");
    command.add_flag("--counters", options.counters, "count what walks do on a device, too (with --json; costs time)");
    addMomentOptions(command, options);
    addStructure(command, options);
    addCommon(command, options);
    command.footer("Examples:\n"
                   "  raig trace bunny.ply --rays rays.npy --hits hits.npy\n"
                   "  raig trace room.glb --rays shadow.npy --hits hits.npy --query any --json");
}

void addCompare(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("compare", "Compare the device with the reference, or two pictures");
    command.callback([&options, &command] {
        options.command = Command::compare;
        if (options.inputs.size() == 2) checkOptionsOfPictures(command);
    });
    addInput(command, options, "first", "a scene, or a picture")->required();
    addInput(command, options, "second", "the picture to compare a picture with");
    addPictureFile(command, options, "the difference picture: .png, .hdr, .exr or .pfm", false);
    addCompareOptions(command, options);
    addCommon(command, options);
    command.option_defaults()->group(optionsOfScenes);
    addPicture(command, options, 256);
    addMomentOptions(command, options);
    addStructure(command, options);
    command.footer("Examples:\n"
                   "  raig compare scene.glb\n"
                   "  raig compare scene.glb --camera 1 --size 1024x1024 --crop 512,256,64,64\n"
                   "  raig compare scene.glb --integrator ao --spp 4\n"
                   "  raig compare a.png b.png -o difference.png --json\n"
                   "  raig compare out.exr reference.exr --fail-above flip_mean=0.01 --fail-below psnr=40\n"
                   "Without --spp a scene gets one sample a pixel.\n"
                   "Files are taken as light: PNG is decoded from sRGB, alpha is left out. max, rmse and relmse are of\n"
                   "light; psnr, ssim and flip of what a screen shows, sRGB from 0 to 1, whatever the files.\n"
                   "Exits with 1 if a metric breaks its bound. A scene's own bounds, where none is given: missed, phantom,\n"
                   "wrong and nan 0, offset_max 1, rmse 0.001; different 0 on a device that computes as IEEE 754 asks.");
}

void addBench(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("bench", "Measure the speed of structures, side by side with Embree");
    command.callback([&options] { options.command = Command::bench; });
    const auto append = [&options](const std::vector<std::string>& files) {
        options.inputs.assign(files.begin(), files.end());
    };
    command.add_option_function<std::vector<std::string>>("scenes", append, ".gltf, .glb, .obj, .ply or .stl files")
        ->type_name("FILE")->required();
    addMomentOptions(command, options);
    addStructure(command, options, "all, which are all but brute");
    const auto parseSide = [&options](const std::string& text) {
        const std::optional<uint32_t> side = wholeNumber(text, 8, 8192);
        if (!side || *side % 8 != 0) throw usageError("--side {}: a multiple of 8 from 8 to 8192 is wanted", text);
        options.side = *side;
    };
    command.add_option_function<std::string>("--side", parseSide, "of the picture whose rays are traced (default: 1024)")
        ->type_name("N");
    addWholeNumber(command, "--repeat", options.repetitions, 1, 1000, "how often each measurement is made (default: 7)");
    const auto parseQueries = [&options](const std::string& text) {
        if (text != "standard" && text != "all") throw usageError("--query {}: standard or all is wanted", text);
        options.bothQueries = text == "all";
    };
    command.add_option_function<std::string>("--query", parseQueries,
                                             "standard: any hit of shadow rays, the closest of the others; all: both of all "
                                             "(default: standard)")
        ->type_name("WHICH");
    CLI::Option* const baseline = command.add_option("--baseline", options.baseline,
                                                     "compare with an earlier run, a file with what --json printed");
    baseline->type_name("FILE");
    const auto parseSlower = [&options](const std::string& text) {
        const std::optional<double> factor = numberOf<double>(text);
        if (!factor || !(*factor >= 1.0 && *factor <= 1000.0))
            throw usageError("--slower {}: a factor from 1 to 1000 is wanted", text);
        options.slower = *factor;
    };
    command.add_option_function<std::string>("--slower", parseSlower,
                                             "fail where something is slower than in the baseline by more than this factor "
                                             "(default: 1.25)")
        ->type_name("FACTOR")->needs(baseline);
    addCommon(command, options);
    command.footer(
        "Examples:\n"
        "  raig bench bunny.ply\n"
        "  raig bench bunny.ply room.glb --accel all --threads 2 --json > before.json\n"
        "  raig bench bunny.ply --device llvmpipe --query all\n"
        "  raig bench bunny.ply room.glb --accel all --threads 2 --baseline before.json --slower 1.1\n"
        "Rays: primary, shadow, diffuse and specular, of a three-quarter view of the whole scene. Each measurement is\n"
        "made in turn with Embree's, where raig was built with it: medians and quartiles of the pairs are told.\n"
        "--device auto measures the best device and the CPU path, --device all every device and that.\n"
        "A baseline is compared by the ratios to Embree, which other machines share, else by Mrays/s. Exits with 1 if\n"
        "something is slower by more than --slower allows.");
}

void addChart(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("chart", "Chart speed against accuracy: figures, their data and one page");
    command.callback([&options] { options.command = Command::chart; });
    addChartOptions(command, options);
    addWholeNumber(command, "--seed", options.seed, 0, largest, "of the random numbers (default: 0)");
    addCommon(command, options);
}

void addStress(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("stress", "Run the hard cases, where methods fail, with every structure");
    command.callback([&options] { options.command = Command::stress; });
    const auto appendCase = [&options](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            const std::optional<uint32_t> number = wholeNumber(text, 0, largest);
            if (!number) throw usageError("--case {}: the number of a case is wanted", text);
            options.cases.push_back(*number);
        }
    };
    command.add_option_function<std::vector<std::string>>("--case", appendCase, "a case, by its number (default: all)")
        ->type_name("N")->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    const auto parseRays = [&options](const std::string& text) {
        const std::optional<uint32_t> count = wholeNumber(text, 1, 10'000'000);  // all of a case are in memory at once
        if (!count) throw usageError("--rays {}: a whole number from 1 to 10000000 is wanted; --seed draws others", text);
        options.rayCount = *count;
    };
    command.add_option_function<std::string>("--rays", parseRays, "rays a case (default: some hundred to some thousand)")
        ->type_name("N");
    const auto parseRay = [&options](const std::string& text) {
        const std::optional<uint32_t> number = wholeNumber(text, 0, largest);
        if (!number) throw usageError("--ray {}: the number of a ray is wanted", text);
        options.ray = *number;
    };
    command.add_option_function<std::string>("--ray", parseRay, "only this ray of the case, and what each says of it")
        ->type_name("K");
    command.add_flag("--long", options.isLong, "30 times the rays, and every option of every structure");
    command.add_flag("--controls", options.onlyControls, "only the controls: textbook methods that must fail");
    command.add_flag("-v,--verbose", options.verbose, "a line for each structure, not for the worst of a case");
    command.add_option("-o,--output", options.folder, "write a page, index.html, and its data, stress.json, to this folder")
        ->type_name("DIR");
    command.add_option("--junit", options.junit, "write the results as JUnit's XML to this file")->type_name("FILE");
    addStructure(command, options, "all, each walked in all its ways", "all");
    addCommon(command, options);
    command.footer(
        "Examples:\n"
        "  raig stress\n"
        "  raig stress --case 13 --case 14 --accel bvh --rays 100000\n"
        "  raig stress --device all -o report --junit stress.xml\n"
        "  raig stress --case 13 --seed 7 --ray 42\n"
        "--device all: all devices and the CPU, one after the other.\n"
        "Exits with 1 if an answer is missed, invented or wrong by exact arithmetic, differs from brute force's bits, or\n"
        "never comes; if a pixel is not what is known of it; or if a control does not fail as it should. Where a device\n"
        "is lost or a limit reached, the others still run and results are written: then it exits with 4 or 5.");
}

void addInfo(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("info", "Tell what a scene holds and what each structure would cost in it");
    command.callback([&options] { options.command = Command::info; });
    addInput(command, options, "scene", "a .gltf, .glb, .obj, .ply or .stl file")->required();
    addMomentOptions(command, options);
    addMemoryBudget(command, options);
    addCommon(command, options);
    command.footer("Examples:\n"
                   "  raig info scene.glb\n"
                   "  raig info bunny.ply --json");
}

void addDevices(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("devices", "List the Vulkan devices, their limits and their arithmetic");
    command.callback([&options] { options.command = Command::devices; });
    addCommon(command, options);
    command.footer("Examples:\n  raig devices\n  raig devices --json");
}

/// CLI11's error in our words: one line that ends with where to look.
Error explained(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv) {
    const std::vector<const CLI::App*> chosen = app.get_subcommands([](const CLI::App* sub) { return sub->parsed(); });
    if (!chosen.empty()) return usageError("{}; see raig {} --help", error.what(), chosen.front()->get_name());
    const char* const* word =
        std::find_if(argv + 1, argv + argc, [](std::string_view text) { return !text.starts_with('-'); });
    const char* const commands = "render, trace, compare, bench, chart, stress, info and devices; see raig --help";
    if (word == argv + argc && argc > 1) return usageError("{}: the commands are {}", error.what(), commands);
    if (word == argv + argc) return usageError("a command is wanted; there are {}", commands);
    return usageError("there is no command {}; there are {}", *word, commands);
}

/// An option that is given and empty is most likely a variable that was not set.
void checkNoneIsEmpty(const CLI::App& app) {
    for (const CLI::App* command : app.get_subcommands())
        for (const CLI::Option* option : command->get_options())
            for (const std::string& text : option->results())
                if (text.empty()) throw usageError("{}: the value is empty; give one, or leave it out", option->get_name());
}

}  // namespace

std::optional<Options> parseOptions(int argc, const char* const* argv) {
    Options options;
    CLI::App app("raig traces rays through 3D scenes on any Vulkan device, and says how right the answers are.", "raig");
    app.set_version_flag("--version", "raig " RAIG_VERSION, "print the version");
    app.require_subcommand(1);
    app.footer("Examples:\n"
               "  raig render scene.glb -o out.png\n"
               "  raig compare scene.glb\n"
               "Options of a command: raig COMMAND --help\n"
               "Exit codes: 0 done, 1 a comparison or check fell short, 2 wrong usage, 3 bad input, 4 no usable device,\n"
               "            5 a limit was reached, 70 a bug in raig");
    addRender(app, options);
    addTrace(app, options);
    addCompare(app, options);
    addBench(app, options);
    addChart(app, options);
    addStress(app, options);
    addInfo(app, options);
    addDevices(app, options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForVersion& version) {
        std::printf("%s\n", version.what());
        return std::nullopt;
    } catch (const CLI::CallForHelp&) {
        std::fputs(app.help().c_str(), stdout);
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw explained(app, error, argc, argv);
    }
    checkNoneIsEmpty(app);
    checkAnimationOptions(options);
    checkViewOptions(options);
    checkSamplingOptions(options);
    checkIntegratorOptions(options);
    checkToneOptions(options);
    checkWrittenFiles(options);
    return options;
}

}  // namespace raig

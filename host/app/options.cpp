#include "app/options.hpp"

#include "app/animation_options.hpp"
#include "app/aov_options.hpp"
#include "app/bench_options.hpp"
#include "app/chart_options.hpp"
#include "app/compare_options.hpp"
#include "app/environment_options.hpp"
#include "app/integrator_options.hpp"
#include "app/option_parts.hpp"
#include "app/primary_options.hpp"
#include "app/sampling_options.hpp"
#include "app/stress_options.hpp"
#include "app/structure_options.hpp"
#include "app/tone_options.hpp"
#include "app/view_options.hpp"
#include "app/written_files.hpp"
#include "base/error.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace raig {

namespace {

/// "0.25" or "1/4", in [0, 1].
std::optional<double> fraction(std::string_view text) {
    const size_t slash = text.find('/');
    const std::optional<double> over = numberOf<double>(text.substr(0, slash));
    const std::optional<double> under = slash == text.npos ? 1.0 : numberOf<double>(text.substr(slash + 1));
    if (!over || !under) return std::nullopt;
    const double value = *over / *under;
    return value >= 0.0 && value <= 1.0 ? std::optional(value) : std::nullopt;  // NaN is neither
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

void addChart(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("chart", "Chart speed against accuracy: figures, their data and one page");
    command.callback([&options] { options.command = Command::chart; });
    addChartOptions(command, options);
    addSeed(command, options);
    addCommon(command, options);
}

void addBench(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("bench", "Measure the speed of structures, side by side with Embree");
    command.callback([&options] { options.command = Command::bench; });
    addBenchOptions(command, options);
}

void addStress(CLI::App& app, Options& options) {
    CLI::App& command = *app.add_subcommand("stress", "Run the hard cases, where methods fail, with every structure");
    command.callback([&options] { options.command = Command::stress; });
    addStressOptions(command, options);
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

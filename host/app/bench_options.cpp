#include "app/bench_options.hpp"

#include "app/animation_options.hpp"
#include "app/option_parts.hpp"
#include "app/structure_options.hpp"
#include "base/error.hpp"

#include <CLI/CLI.hpp>

namespace raig {

void addBenchOptions(CLI::App& command, Options& options) {
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

}  // namespace raig

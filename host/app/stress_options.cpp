#include "app/stress_options.hpp"

#include "app/option_parts.hpp"
#include "app/structure_options.hpp"
#include "base/error.hpp"

#include <CLI/CLI.hpp>

#include <limits>

namespace raig {

namespace {

constexpr uint32_t largest = std::numeric_limits<uint32_t>::max();

}  // namespace

void addStressOptions(CLI::App& command, Options& options) {
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

}  // namespace raig

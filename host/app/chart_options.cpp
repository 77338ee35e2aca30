#include "app/chart_options.hpp"

#include <CLI/CLI.hpp>

namespace raig {

void addChartOptions(CLI::App& command, Options& options) {
    const auto append = [&options](const std::vector<std::string>& files) {
        options.inputs.assign(files.begin(), files.end());
    };
    command.add_option_function<std::vector<std::string>>("scenes", append, ".gltf, .glb, .obj, .ply or .stl files")
        ->type_name("FILE")->required();
    command.add_option("-o,--output", options.folder, "the folder to write index.html, figures and data to")
        ->type_name("DIR")->required();
    const auto appendSweep = [&options](const std::vector<std::string>& files) {
        options.sweeps.assign(files.begin(), files.end());
    };
    const char* const sweep = "a JSON file that declares more figures; -o DIR gets raig's own as sweeps.json, to start from";
    command.add_option_function<std::vector<std::string>>("--sweep", appendSweep, sweep)
        ->type_name("FILE")->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--figure", options.figures, "only this figure, by its name (default: all)")
        ->type_name("NAME")->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_flag("--fresh", options.fresh, "measure all anew, also what an earlier run in DIR has measured");
    command.footer(
        "Examples:\n"
        "  raig chart assets/cornell_spheres.gltf -o report\n"
        "  raig chart bunny.ply stadium.glb -o report --figure methods --figure grid-density\n"
        "  raig chart bunny.ply -o report --sweep leaves.json --figure leaves\n"
        "with leaves.json, where an array varies and all else is held:\n"
        "  {\"name\": \"leaves\", \"title\": \"Leaves\", \"task\": \"trace\",\n"
        "   \"settings\": {\"accel\": [\"bvh\", \"kdtree\"], \"max-leaf\": [1, 2, 4, 8], \"rays\": \"diffuse\"},\n"
        "   \"draw\": {\"x\": \"max-leaf\", \"y\": \"milliseconds\", \"by\": [\"accel\"], \"style\": \"lines\"},\n"
        "   \"holds\": {\"measure\": \"differing\", \"most\": 0, \"because\": \"hits must not change\"}}\n"
        "A chart that was interrupted goes on where it was. Exits with 1 if what was measured lies outside of what theory\n"
        "allows.");
}

}  // namespace raig

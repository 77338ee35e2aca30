// `raig info`: what a scene holds, what it needs, and what each structure would cost in it.
#include "app/commands.hpp"
#include "app/progress.hpp"
#include "app/structure_source.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "measure/trials.hpp"
#include "rays/economy.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <limits>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

/// All that is said of a scene.
struct Survey {
    Scene scene;
    Geometry geometry;
    SceneNumbers numbers;
    TriangleCounts counts;  ///< as instances, and written out
    std::vector<std::string> features;
    uint32_t materials = 0;  ///< in use
    Economy economy;         ///< of pictures, as renderings make them: instances kept where that is worth it
    std::vector<std::string> warnings;
    std::vector<Trial> trials;
    Choice choice;
};

double perTriangle(double amount, const Survey& survey) {
    return survey.numbers.usable == 0 ? 0.0 : amount / static_cast<double>(survey.numbers.usable);
}

std::vector<std::string> listWarnings(const SceneNumbers& numbers) {
    std::vector<std::string> warnings;
    if (numbers.usable == 0) warnings.emplace_back("no triangle or sphere can be hit: there is nothing to see");
    if (numbers.isUneven())
        warnings.push_back(
            fmt::format("triangles crowd together in a part of the scene, {:.0f} in a cell of one uniform grid on "
                        "average: grid --levels 1 would be slow",
                        numbers.crowding));
    return warnings;
}

/// Structures that test many times as many primitives as the best one does.
void warnOfSlowStructures(Survey& survey) {
    constexpr double many = 1000.0, times = 20.0;
    double least = std::numeric_limits<double>::infinity();
    for (const Trial& trial : survey.trials)
        if (trial.trouble.empty()) least = std::min(least, trial.cost.triangleTests);
    for (const Trial& trial : survey.trials)
        if (trial.trouble.empty() && trial.name != "brute" && trial.cost.triangleTests > std::max(many, times * least))
            survey.warnings.push_back(fmt::format("{} would be slow: {:.0f} primitives are tested a ray, {:.0f} at best",
                                                  trial.name, trial.cost.triangleTests, least));
}

Survey surveyScene(const Options& options) {
    Survey survey;
    survey.scene = importScene(options.inputs.front(), options.moment);
    survey.geometry = flatten(survey.scene);
    survey.counts = countTriangles(survey.scene, worthwhile);
    const std::vector<Primitive> triangles = primitivesOf(survey.geometry);
    survey.numbers = measureScene(triangles);
    survey.features = featuresOf(survey.scene, survey.geometry);
    survey.materials = countUsedMaterials(survey.scene, survey.geometry);
    survey.economy =
        measureEconomy(survey.scene, isWorthKeeping(survey.counts) ? gatherInstances(survey.scene) : survey.geometry);
    survey.warnings = listWarnings(survey.numbers);

    Progress progress("structures");
    TrialOptions trial{.memoryBudget = options.buildParams.memoryBudget};
    trial.progress = [&](const std::string& name, double done) { progress.update("trying " + name, done); };
    survey.trials = tryStructures(survey.scene, survey.geometry, triangles, trial);
    warnOfSlowStructures(survey);
    survey.choice = chooseStructure(triangles.size(), survey.trials);
    return survey;
}

Json toJson(const vec3& v) {
    return {v.x, v.y, v.z};
}

Json clipsJson(const Scene& scene) {
    Json clips = Json::array();
    for (const Clip& clip : scene.clips) clips.push_back({{"name", clip.name}, {"seconds", clip.seconds}});
    return clips;
}

std::string describeClips(const Scene& scene) {
    constexpr size_t shown = 8;
    std::string text;
    for (size_t i = 0; i < std::min(shown, scene.clips.size()); ++i) {
        const Clip& clip = scene.clips[i];
        text += fmt::format("{}{} {} ({:.4g} s)", i ? ", " : "", i, clip.name.empty() ? "(unnamed)" : clip.name,
                            clip.seconds);
    }
    return scene.clips.size() > shown ? fmt::format("{} and {} more", text, scene.clips.size() - shown) : text;
}

Json economyJson(const Economy& economy) {
    Json leftOut = Json::array();
    for (const LeftOut& each : economy.leftOut)
        leftOut.push_back({{"name", each.name}, {"instructions", each.instructions}});
    return {{"used", economy.used},
            {"left_out", leftOut},
            {"instructions", economy.instructions},
            {"all_instructions", economy.allInstructions},
            {"vertices", economy.vertices},
            {"vertex_bytes", economy.vertexBytes},
            {"all_vertex_bytes", economy.allVertexBytes},
            {"stored_primitives", economy.storedTriangles},
            {"texture_bytes", economy.textureBytes},
            {"named_texture_bytes", economy.namedTextureBytes}};
}

Json sceneJson(const Options& options, const Survey& survey) {
    const SceneNumbers& numbers = survey.numbers;
    const Scene& scene = survey.scene;
    const bool empty = numbers.bounds.empty();
    return {{"file", options.inputs.front().string()},
            {"triangles", numbers.triangles},
            {"spheres", numbers.spheres},
            {"usable_triangles", numbers.usable},
            {"dropped",
             {{"non_finite", survey.geometry.dropped.nonFinite},
              {"zero_area", survey.geometry.dropped.zeroArea},
              {"other", survey.geometry.dropped.other}}},
            {"instances", scene.instances.size()},
            {"stored_triangles", survey.counts.stored},
            {"keeps_instances", isWorthKeeping(survey.counts)},
            {"meshes", scene.meshes.size()},
            {"materials", scene.materials.size()},
            {"used_materials", survey.materials},
            {"images", scene.images.size()},
            {"animations", clipsJson(scene)},
            {"lights", scene.lights.size()},
            {"cameras", scene.cameras.size()},
            {"features", survey.features},
            {"economy", economyJson(survey.economy)},
            {"bounds", empty ? Json() : Json{{"lo", toJson(numbers.bounds.lo)}, {"hi", toJson(numbers.bounds.hi)}}},
            {"extent", toJson(empty ? vec3(0.0f) : numbers.bounds.extent())},
            {"largest_triangle", numbers.largestExtent},
            {"median_triangle", numbers.medianExtent},
            {"sizes_ratio", numbers.sizesRatio()},
            {"crowding", numbers.crowding},
            {"remarks", scene.remarks},
            {"warnings", survey.warnings}};
}

Json trialJson(const Trial& trial, const Survey& survey) {
    if (!trial.trouble.empty()) return {{"name", trial.name}, {"trouble", trial.trouble}};
    const StructureStatistics& built = trial.structure.statistics;
    return {{"name", trial.name},
            {"walk", trial.structure.walk},
            {"build_s", built.seconds},
            {"bytes", built.bytes},
            {"bytes_per_triangle", perTriangle(double(built.bytes), survey)},
            {"nodes", built.nodes},
            {"leaves", built.leaves},
            {"depth", built.depth},
            {"references", built.references},
            {"references_per_triangle", perTriangle(double(built.references), survey)},
            {"sah", built.sahCost},
            {"predicted",
             {{"node_visits", trial.cost.nodeVisits},
              {"triangle_tests", trial.cost.triangleTests},
              {"weight", trial.cost.weight},
              {"cost", trial.cost.total()}}}};
}

void printJson(const Options& options, const Survey& survey) {
    Json structures = Json::array();
    for (const Trial& trial : survey.trials) structures.push_back(trialJson(trial, survey));
    const Json document = {{"scene", sceneJson(options, survey)},
                           {"structures", structures},
                           {"auto", {{"structure", survey.choice.structure}, {"why", survey.choice.why}}}};
    std::puts(document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void printScene(const Survey& survey) {
    const SceneNumbers& numbers = survey.numbers;
    const Scene& scene = survey.scene;
    const auto row = [](const char* name, const std::string& text) { fmt::print("{:12}{}\n", name, text); };
    const std::string spheres = numbers.spheres > 0 ? fmt::format(" and {} spheres", numbers.spheres) : "";
    row("triangles", fmt::format("{}{}, {} of them usable", numbers.triangles, spheres, numbers.usable));
    row("parts", fmt::format("{} instances of {} meshes, {} materials ({} used), {} images", scene.instances.size(),
                             scene.meshes.size(), scene.materials.size(), survey.materials, scene.images.size()));
    if (isWorthKeeping(survey.counts))
        row("instances", fmt::format("kept where not told otherwise: {} triangles in memory", survey.counts.stored));
    row("view", fmt::format("{} cameras, {} lights", scene.cameras.size(), scene.lights.size()));
    if (!scene.clips.empty()) row("animations", describeClips(scene));
    row("uses", survey.features.empty() ? "plain triangles" : fmt::format("{}", fmt::join(survey.features, ", ")));
    for (const std::string& line : describe(survey.economy)) row("", line);
    if (numbers.bounds.empty()) return;
    const Box& b = numbers.bounds;
    row("bounds",
        fmt::format("({:.6g} {:.6g} {:.6g}) to ({:.6g} {:.6g} {:.6g})", b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z));
    row("extent", fmt::format("{:.6g} x {:.6g} x {:.6g}", b.extent().x, b.extent().y, b.extent().z));
    row("sizes", fmt::format("largest triangle {:.4g}, median {:.4g}: {:.4g} to 1", numbers.largestExtent,
                             numbers.medianExtent, numbers.sizesRatio()));
    row("crowding", fmt::format("{:.1f} triangles share a cell of a uniform grid", numbers.crowding));
}

void printStructures(const Survey& survey) {
    constexpr const char* head = "\n{:10} {:24} {:>8} {:>8} {:>9} {:>10} {:>5} {:>9} {:>9}  {:>9} {:>9} {:>9}\n";
    fmt::print(fmt::runtime(head), "structure", "walk", "build s", "MiB", "bytes/tri", "nodes", "depth", "refs/tri", "SAH",
               "visits", "tests", "cost");
    for (const Trial& trial : survey.trials) {
        if (!trial.trouble.empty()) {
            fmt::print("{:10} {}\n", trial.name, trial.trouble);
            continue;
        }
        const StructureStatistics& built = trial.structure.statistics;
        fmt::print("{:10} {:24} {:>8.3f} {:>8.2f} {:>9.1f} {:>10} {:>5} {:>9.2f} {:>9.1f}  {:>9.1f} {:>9.1f} {:>9.1f}\n",
                   trial.name, trial.structure.walk, built.seconds, double(built.bytes) / (1 << 20),
                   perTriangle(double(built.bytes), survey), built.nodes, built.depth,
                   perTriangle(double(built.references), survey), built.sahCost, trial.cost.nodeVisits,
                   trial.cost.triangleTests, trial.cost.total());
    }
    fmt::print("visits, tests: of a ray, counted with rays of a picture and their bounces; "
               "cost: visits + 2 tests, weighted; no time\n");
}

}  // namespace

int info(const Options& options) {
    const Survey survey = surveyScene(options);
    for (const std::string& remark : survey.scene.remarks) log::note("remark: {}", remark);
    for (const std::string& warning : survey.warnings) log::warn("{}", warning);
    if (options.json) {
        printJson(options, survey);
    } else {
        printScene(survey);
        printStructures(survey);
        fmt::print("\nauto: {}: {}\n", survey.choice.structure, survey.choice.why);
    }
    return static_cast<int>(ExitCode::done);
}

}  // namespace raig

#include "app/structure_source.hpp"

#include "app/progress.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "measure/trials.hpp"
#include "rays/lights.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"

#include <chrono>

namespace raig {

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void checkIsAskedFor(const StructureFile& file, const Options& options) {
    if (options.accelGiven && options.accel != "auto" && file.structureName() != options.accel)
        throw inputError(options.loadStructure, "holds a {}, not the {} of --accel; leave out --accel, or --load-structure",
                         file.structureName(), options.accel);
    const std::string wanted = describeOptions(options.buildParams), found = file.options();
    if (!wanted.empty() && wanted != found)
        throw inputError(options.loadStructure,
                         "was built with {}, not with {}; leave out these options, or --load-structure",
                         found.empty() ? "no options" : found, wanted);
}

bool usesFile(const Options& options) {
    return !options.saveStructure.empty() || !options.loadStructure.empty();
}

/// A scene is kept as instances or written out as it was for the file.
void checkInstancesOf(const StructureFile& file, const Options& options) {
    const bool keeps = file.leastTriangles() > 0;
    if (options.instances == "keep" && !keeps)
        throw inputError(options.loadStructure,
                         "is of a scene written out; leave out --instances keep, or write it again with that");
    if (options.instances == "flatten" && keeps)
        throw inputError(options.loadStructure,
                         "is of a scene kept as instances; leave out --instances flatten, or write it again with that");
}

/// Of all options of structures, only the budget is every structure's.
void checkAuto(const Options& options) {
    BuildParams params = options.buildParams;
    params.memoryBudget = BuildParams{}.memoryBudget;
    const std::string given = describeOptions(params);
    if (options.accel == "auto" && !given.empty())
        throw usageError("{}: --accel auto tries structures as they are; name one with it, or leave this out", given);
}

}  // namespace

StructureSource::StructureSource(const Options& options) : options_(options), params_(options.buildParams) {
    if (options.accel != "auto") structureType(options.accel);
    checkAuto(options);
    if (options.loadStructure.empty()) return;
    file_ = std::make_unique<StructureFile>(options.loadStructure);
    checkIsAskedFor(*file_, options);
    checkInstancesOf(*file_, options);
}

Structure StructureSource::choose(const Scene& scene, const Geometry& geometry, std::span<const Primitive> triangles) {
    std::vector<Trial> trials;
    if (triangles.size() <= mostForTrials) {
        Progress progress("trying structures");
        TrialOptions trial{.memoryBudget = options_.buildParams.memoryBudget, .keepStructures = true};
        trial.progress = [&](const std::string& name, double done) { progress.update("trying " + name, done); };
        trials = tryStructures(scene, geometry, triangles, trial);
    }
    const Choice choice = chooseStructure(triangles.size(), trials);
    log::note("auto: {}: {}", choice.structure, choice.why);
    for (Trial& trial : trials)
        if (trial.name == choice.structure) return std::move(trial.structure);
    return structureType(choice.structure).build(triangles, options_.buildParams);
}

bool StructureSource::keepsInstances(const Scene& scene) const {
    if (file_) return file_->leastTriangles() > 0;
    if (options_.instances != "auto") return options_.instances == "keep";
    return isWorthKeeping(countTriangles(scene, worthwhile));
}

template <class Build>
Structure StructureSource::buildWithin(const Build& build) const {
    try {
        return build(params_);
    } catch (const Error& error) {
        if (error.exitCode != ExitCode::limit || !choseWalk_) throw;
    }
    return build(options_.buildParams);  // where memory is short, the builder knows better which walk it allows
}

template <class Over, class Build>
Structure StructureSource::readOrBuild(Clock::time_point start, const Over& over, const Build& build) {
    Structure structure = file_ ? file_->read(over) : build();
    (file_ ? loadSeconds_ : buildSeconds_) = secondsSince(start);
    if (!options_.saveStructure.empty()) saveStructure(options_.saveStructure, structure, options_.buildParams, over);
    return structure;
}

Structure StructureSource::makeTwoLevels(const Geometry& geometry) {
    const bool picks = options_.accel == "auto" && !file_;
    if (picks) log::note("auto: bvh: the scene is kept as instances; others would have to be tried with all written out");
    const KeepRule rule = file_ ? KeepRule{file_->leastTriangles()} : options_.instances == "keep" ? KeepRule{} : worthwhile;
    const Clock::time_point start = Clock::now();
    const PlacedScene scene = placedScene(geometry, rule);
    return readOrBuild(start, scene, [&] {
        const StructureType& type = structureType(picks ? "bvh" : options_.accel);
        return buildWithin([&](const BuildParams& params) { return buildTwoLevels(scene, type, params); });
    });
}

Structure StructureSource::makeOneLevel(const Scene& scene, const Geometry& geometry) {
    const std::vector<Primitive> triangles = primitivesOf(geometry);
    const std::span<const Primitive> over = triangles;
    return readOrBuild(Clock::now(), over, [&] {
        if (options_.accel == "auto") return choose(scene, geometry, over);
        const StructureType& type = structureType(options_.accel);
        return buildWithin([&](const BuildParams& params) { return type.build(over, params); });
    });
}

Structure StructureSource::make(const Scene& scene, const Geometry& geometry) {
    Structure structure = geometry.isInstanced() ? makeTwoLevels(geometry) : makeOneLevel(scene, geometry);
    markSeeThrough(scene, geometry, structure);
    return structure;
}

bool StructureSource::leavesWalkOpen() const {
    const BuildParams& given = options_.buildParams;
    // What is saved must not depend on how fast anything was.
    return !usesFile(options_) && options_.accel == "bvh" && given.walk == "auto" && given.bound.empty() &&
           given.arity == 0 && given.precision == 0;
}

void StructureSource::setWalk(const WalkChoice& choice) {
    // Octants are what auto means to the builder, which knows better what to do where memory is short.
    if (choice.walk == "octants") return;
    choseWalk_ = true;
    params_.walk = choice.walk;
    params_.arity = choice.arity;
}

std::string StructureSource::origin(const Structure& structure) const {
    const std::string built = fmt::format("built in {:.3f} s", structure.statistics.seconds);
    if (!file_) return built;
    return fmt::format("read from {} in {:.3f} s instead of {}", options_.loadStructure.string(), loadSeconds_, built);
}

}  // namespace raig

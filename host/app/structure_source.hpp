/// Where the structure of a command comes from: it is built, or read from a file.
#pragma once

#include "app/options.hpp"
#include "measure/walk_choice.hpp"
#include "scene/geometry.hpp"
#include "structures/structure_file.hpp"

#include <chrono>
#include <memory>

namespace raig {

class StructureSource {
public:
    /// Throws what is wrong with --accel, and with the start of the file of --load-structure, before a scene is read:
    /// usageError, or inputError if the file holds another structure, or other options, than are asked for, or is of a scene
    /// written out where instances are to be kept, or the other way around.
    explicit StructureSource(const Options& options);

    /// Builds, chooses (--accel auto, and says why) or reads the structure of the scene, saves it if --save-structure is
    /// given, and marks what lets light through. Throws what building, reading and saving throw.
    /// Where geometry.isInstanced(), the structure has two levels.
    Structure make(const Scene& scene, const Geometry& geometry);

    /// True if the fastest walk of bvh is wanted, whichever that is (--walk auto), and nothing that depends on the walk.
    bool leavesWalkOpen() const;
    /// Takes that walk, unless the memory budget allows the builder only another. Requires leavesWalkOpen().
    void setWalk(const WalkChoice& choice);

    /// True if the scene is to be kept as instances: as it was for the file that is read; else by --instances and what is
    /// in it.
    bool keepsInstances(const Scene& scene) const;

    /// How `structure` came here, in words.
    std::string origin(const Structure& structure) const;
    double buildSeconds() const { return buildSeconds_; }  ///< 0 where it was read
    double loadSeconds() const { return loadSeconds_; }    ///< 0 where it was built

private:
    Structure makeOneLevel(const Scene& scene, const Geometry& geometry);
    Structure makeTwoLevels(const Geometry& geometry);
    using Clock = std::chrono::steady_clock;
    /// `over` is what the structure is of: a PlacedScene, or primitives. Counts the time since `start`.
    template <class Over, class Build>
    Structure readOrBuild(Clock::time_point start, const Over& over, const Build& build);
    template <class Build>
    Structure buildWithin(const Build& build) const;
    Structure choose(const Scene& scene, const Geometry& geometry, std::span<const Primitive> triangles);

    const Options& options_;
    BuildParams params_;  ///< those of the options, and the walk that was chosen
    bool choseWalk_ = false;
    std::unique_ptr<StructureFile> file_;
    double buildSeconds_ = 0.0;
    double loadSeconds_ = 0.0;
};

}  // namespace raig

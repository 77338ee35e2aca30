/// What every structure would cost in a scene, found by building each and walking it with some rays; and which one to take.
///
/// The cost of a ray is predicted as
///     weight x (node visits + 2 x triangle tests)
/// counted by the CPU's walk and averaged over the sample rays: a picture of 48 x 48 from the scene's first camera (or from
/// outside, where that one sees little), and the diffuse bounces off what it shows. A unit is one node or cell looked at;
/// that a triangle's test is worth two of them is what was measured on lavapipe for bvh. The weight is 1 for bvh and brute,
/// and 2 for all others: so much more time than bvh's a unit of kdtree's took there (1.8 to 2.3 on bunny, classroom and
/// fzk_haus; 1.4 to 1.9 on the CPU), as finding the way from one cell to the next is not counted. Costs compare structures
/// on one scene. They are no times: a node's bytes, a device's width and its caches are not in them.
///
/// Why not the surface area heuristic's cost: it takes rays to come from everywhere and to pass through what they hit. It
/// compares trees of one kind well, but not a tree with a grid, and says little of scenes that hide most of themselves.
#pragma once

#include "measure/scene_numbers.hpp"
#include "rays/tracer.hpp"

#include <functional>

namespace raig {

struct PredictedCost {
    double nodeVisits = 0.0;  ///< of a ray, on average
    double triangleTests = 0.0;
    double weight = 1.0;  ///< of a unit of the structure's work
    double total() const { return weight * (nodeVisits + 2.0 * triangleTests); }
};

/// A structure as it was built, or why it was not.
struct Trial {
    std::string name;
    std::string trouble;  ///< empty if it was built
    Structure structure;  ///< without nodes and triangles, unless they were to be kept
    PredictedCost cost;
};

struct TrialOptions {
    uint64_t memoryBudget = BuildParams{}.memoryBudget;
    bool keepStructures = false;
    /// Told before each structure is built: its name and the share of the work done.
    std::function<void(const std::string&, double)> progress = [](const std::string&, double) {};
};

/// Most triangles that brute is tried with: its every ray tests all.
inline constexpr uint64_t mostForBrute = 4096;

/// Builds every structure of registry.def with its own defaults, in that order, and predicts its cost. The same every time.
/// A limitError of a builder is that trial's trouble.
std::vector<Trial> tryStructures(const Scene& scene, const Geometry& geometry, std::span<const Primitive> triangles,
                                 const TrialOptions& options);

struct Choice {
    std::string structure;
    std::string why;  ///< one line
};

/// Most triangles that --accel auto tries all structures with: beyond, building them takes longer than the best could save.
inline constexpr uint64_t mostForTrials = 250'000;

/// The rule of --accel auto, in one place:
///     more than mostForTrials triangles         bvh, untried: it is built fastest and takes the least memory
///     bvh within 1.25 of the cheapest           bvh: the counts tell no smaller difference in time, and its walk is the one
///                                               that was tuned and measured on devices
///     else                                      the cheapest; of equals the first in registry.def
/// Requires trials of all structures where there are no more triangles than mostForTrials; of them, those that were built.
Choice chooseStructure(uint64_t triangles, std::span<const Trial> trials);

}  // namespace raig

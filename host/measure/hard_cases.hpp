/// The catalogue of hard cases, where methods of tracing rays fail: primitives and rays by the recipe of each case.
#pragma once

#include "base/random.hpp"
#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <memory>
#include <string>
#include <vector>

namespace raig {
struct Scene;
}  // namespace raig

namespace raig::hard {

/// What the scenes of a case are drawn by: the same values draw the same triangles and rays.
struct Draw {
    uint32_t seed = 0;
    uint32_t times = 1;  ///< as many rays as in a short run

    size_t rays(size_t ofShortRun) const { return ofShortRun * times; }
    /// Numbers of their own for each `purpose`.
    Random random(uint64_t purpose) const { return Random(purpose ^ (uint64_t{seed} << 32)); }
};

struct Scene {
    std::string name;
    std::vector<Primitive> triangles;  ///< and spheres
    std::vector<Ray> rays;
    /// No operation that decides a hit rounds: then no ray is open (measure/oracle.hpp), and all are judged.
    bool exact = false;
    /// Of the rays, how many may be open at most: 0 where meshes are closed as far as they are seen.
    double mostOpen = 0.0;
    /// Of each ray, the primitive that it must hit by the recipe, whatever exact arithmetic makes of the ray; or empty.
    std::vector<uint32_t> meets = {};
    /// The same primitives as meshes that stand in several places: structures are then built in two levels. Or null.
    std::shared_ptr<const raig::Scene> placed = {};
};

/// A case by its number in the catalogue: a stable name.
struct Case {
    uint32_t number;
    const char* what;
    std::vector<Scene> (*make)(const Draw&);  ///< none where it is judged otherwise (measure/stress_pictures.hpp)

    bool isOfRays() const { return make != nullptr; }
};

std::vector<Case> boxCases();       ///< 1 to 12
std::vector<Case> triangleCases();  ///< 13 to 31
std::vector<Case> cellCases();      ///< 32 to 49
std::vector<Case> laterCases();     ///< 50, 51 and 63: rays that leave surfaces, spheres, instances

/// All of those, by number.
std::vector<Case> allCases();

/// And those that are judged by pictures, or otherwise.
std::vector<Case> allCasesOfAnyKind();

/// What of the catalogue is not run, or not all of it, by number.
struct NotRun {
    uint32_t number;
    const char* what;
    const char* why;
};
std::vector<NotRun> notRun();

/// The case of that number, of any kind. Throws usageError, which lists those there are.
Case caseOf(uint32_t number);

}  // namespace raig::hard

/// The catalogue of hard cases (sections 1 to 3): triangles and rays by the recipe of each case.
#pragma once

#include "base/random.hpp"
#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <array>
#include <string>
#include <vector>

namespace raig::test {

struct HardScene {
    std::string name;
    std::vector<Triangle> triangles;
    std::vector<Ray> rays;
    /// No operation that decides a hit rounds: then no ray is open (support/oracle.hpp), and all are judged.
    bool exact = false;
    /// Of the rays, how many may be open at most: 0 where meshes are closed as far as they are seen.
    double mostOpen = 0.0;
};

/// A case by its number in the catalogue.
struct HardCase {
    int number;
    const char* what;
    std::vector<HardScene> (*make)();
};

std::vector<HardCase> boxCases();       ///< 1 to 12
std::vector<HardCase> triangleCases();  ///< 13 to 31
std::vector<HardCase> cellCases();      ///< 32 to 49

/// The case of that number, of all.
HardCase hardCase(int number);

/// For tests with one parameter: "Case13".
std::string nameOfCase(int number);
std::vector<int> numbersOf(const std::vector<HardCase>& cases);

/// Expects that brute force has no missed, phantom, wrong or unsound hit by the oracle, and that few enough rays are open.
void expectBruteForceIsExact(const HardCase& hardCase);

/// Expects that every structure answers with the bits of brute force, and any-hit queries as closest-hit ones: its variants
/// of every walk, or in a long run all variants.
void expectEveryStructureAnswersAsBruteForce(const HardCase& hardCase);

/// `count` rays a scene, many times that in a long run.
size_t raysOf(size_t count);

/// A closed box: six faces, cut at the coordinates given along each axis (the first and the last are its sides), two
/// triangles a rectangle.
struct CutBox {
    std::array<std::vector<float>, 3> cuts;

    std::vector<Triangle> triangles() const;
    Box box() const;
};

/// A box with `inner` random cuts along each axis, that lie in its middle half.
CutBox randomCutBox(Random& random, const dvec3& centre, double size, int inner);

/// A wall of squares between the whole numbers 0 and `side`, across `axis` at `place`.
std::vector<Triangle> squares(int axis, float place, int side);

/// A zero of either sign.
float anyZero(Random& random);

}  // namespace raig::test

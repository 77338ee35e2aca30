/// What tests ask of the hard cases (measure/hard_cases.hpp).
#pragma once

#include "measure/hard_cases.hpp"

#include <string>
#include <vector>

namespace raig::test {

/// The scenes of the case of that number; with many times the rays in a long run.
std::vector<hard::Scene> hardScenes(uint32_t number);

/// For tests with one parameter: "Case13".
std::string nameOfCase(uint32_t number);
std::vector<uint32_t> numbersOf(const std::vector<hard::Case>& cases);

/// Expects that brute force has no missed, phantom, wrong or unsound hit by the oracle, and that few enough rays are open.
void expectBruteForceIsExact(uint32_t number);

/// Expects that every structure answers with the bits of brute force, and any-hit queries as closest-hit ones: its variants
/// of every walk, or in a long run all variants.
void expectEveryStructureAnswersAsBruteForce(uint32_t number);

}  // namespace raig::test

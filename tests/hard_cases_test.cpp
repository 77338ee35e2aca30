// The hard cases by their number in the catalogue: every structure against brute force, by bits, and brute force against
// exact arithmetic.
#include "support/hard_cases.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

class HardCase : public testing::TestWithParam<uint32_t> {};

TEST_P(HardCase, BruteForceIsExact) {
    test::expectBruteForceIsExact(GetParam());
}

TEST_P(HardCase, EveryStructureAnswersAsBruteForce) {
    test::expectEveryStructureAnswersAsBruteForce(GetParam());
}

const auto byNumber = [](const auto& info) { return test::nameOfCase(info.param); };
INSTANTIATE_TEST_SUITE_P(Boxes, HardCase, testing::ValuesIn(test::numbersOf(hard::boxCases())), byNumber);
INSTANTIATE_TEST_SUITE_P(Triangles, HardCase, testing::ValuesIn(test::numbersOf(hard::triangleCases())), byNumber);
INSTANTIATE_TEST_SUITE_P(Cells, HardCase, testing::ValuesIn(test::numbersOf(hard::cellCases())), byNumber);
INSTANTIATE_TEST_SUITE_P(Later, HardCase, testing::ValuesIn(test::numbersOf(hard::laterCases())), byNumber);

}  // namespace
}  // namespace raig

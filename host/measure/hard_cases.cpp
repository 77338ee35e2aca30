#include "measure/hard_cases.hpp"

#include "base/error.hpp"

#include <fmt/ranges.h>

namespace raig::hard {

std::vector<Case> allCases() {
    std::vector<Case> all;
    for (const auto& cases : {boxCases(), triangleCases(), cellCases(), laterCases()})
        all.insert(all.end(), cases.begin(), cases.end());
    return all;
}

Case caseOf(uint32_t number) {
    std::vector<uint32_t> numbers;
    for (const Case& one : allCases()) {
        if (one.number == number) return one;
        numbers.push_back(one.number);
    }
    throw usageError("--case {}: there is no such case; there are {}", number, fmt::join(numbers, ", "));
}

}  // namespace raig::hard

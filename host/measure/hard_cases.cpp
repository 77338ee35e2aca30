#include "measure/hard_cases.hpp"

#include "base/error.hpp"
#include "measure/hard_pictures.hpp"

#include <fmt/ranges.h>

#include <algorithm>

namespace raig::hard {

std::vector<Case> allCases() {
    std::vector<Case> all;
    for (const auto& cases : {boxCases(), triangleCases(), cellCases(), laterCases()})
        all.insert(all.end(), cases.begin(), cases.end());
    return all;
}

std::vector<Case> allCasesOfAnyKind() {
    std::vector<Case> all = allCases();
    for (const PictureCase& one : pictureCases()) all.push_back({one.number, one.what, nullptr});
    all.push_back({62, "links that lead around", nullptr});
    std::sort(all.begin(), all.end(), [](const Case& a, const Case& b) { return a.number < b.number; });
    return all;
}

std::vector<NotRun> notRun() {
    return {{60, "a budget of one loop iteration, killing and going on", "pictures cannot be resumed yet"},
            {61, "a picture of which pixels are no numbers", "there is no such AOV yet"}};
}

Case caseOf(uint32_t number) {
    std::vector<uint32_t> numbers;
    for (const Case& one : allCasesOfAnyKind()) {
        if (one.number == number) return one;
        numbers.push_back(one.number);
    }
    throw usageError("--case {}: there is no such case; there are {}", number, fmt::join(numbers, ", "));
}

}  // namespace raig::hard

/// What `raig stress` found, as tables on standard output.
#pragma once

#include "measure/stress_page.hpp"

#include <cstdint>

namespace raig {

/// One line a case and device, the worst of its structures; or, `verbose`, one line for each. What failed comes first.
void printResults(const StressDocument& document, bool verbose);

/// One line a control, those first that do not fail. Nothing if there is none.
void printControls(const StressDocument& document);

/// What of the catalogue is missing. Nothing if all is there.
void printNotRun(const StressDocument& document);

/// Ray `number` of the document's one case, and what each structure says of it.
void printReplay(const StressDocument& document, const StressReplay& replay, uint64_t number);

}  // namespace raig

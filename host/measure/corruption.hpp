/// Structures that were sound when they were built, and then led astray in memory: what hard case 62 and tests are about.
#pragma once

#include "structures/structure.hpp"

namespace raig {

/// Makes links lead to where they come from, and lists go on for ever: of a walk that trusts them no ray would end. False,
/// and nothing is changed, if the structure has none. Requires one level, as built by its builder.
bool leadAround(Structure& structure);

}  // namespace raig

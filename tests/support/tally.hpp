/// What the oracle (measure/oracle.hpp) makes of the hits of many rays.
#pragma once

#include "measure/oracle.hpp"

#include <iosfwd>
#include <map>
#include <span>
#include <string>

namespace raig::test {

/// Verdicts of many rays. `open` rays have none, see hard::Oracle.
struct Tally {
    std::map<hard::Verdict, size_t> counts;
    size_t rays = 0;
    size_t hits = 0;     ///< in exact arithmetic
    size_t open = 0;     ///< rays whose answer is rounding's to decide
    size_t unsound = 0;  ///< hits found farther from their triangle than rounding explains
    std::string first;   ///< the first ray whose verdict is missed, phantom or wrong, or whose hit is unsound

    size_t of(hard::Verdict verdict) const;
    size_t failures() const {
        return of(hard::Verdict::missed) + of(hard::Verdict::phantom) + of(hard::Verdict::wrong) + unsound;
    }
};

std::ostream& operator<<(std::ostream& out, const Tally& tally);

/// Judges hits[i] of rays[i]; `strict` as of hard::Oracle.
Tally judge(const hard::Oracle& oracle, std::span<const Ray> rays, std::span<const Hit> hits, bool strict);

}  // namespace raig::test

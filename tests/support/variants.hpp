/// The variants of structures (measure/variants.hpp) that tests go through which hold for every structure.
#pragma once

#include "measure/variants.hpp"
#include "support/effort.hpp"

#include <ostream>
#include <vector>

namespace raig {

inline std::ostream& operator<<(std::ostream& out, const Variant& variant) {
    return out << nameOf(variant);
}

namespace test {

using raig::Variant;
using raig::walkVariants;

/// In a long run, really all.
inline std::vector<Variant> allVariants() {
    return raig::allVariants(isLong());
}

}  // namespace test

}  // namespace raig

/// The structures of host/structures/registry.def in all their forms: what tests go through that hold for every structure.
#pragma once

#include "structures/structure.hpp"

#include <string>
#include <vector>

namespace raig::test {

/// A structure with options.
struct Variant {
    std::string structure;
    BuildParams params;

    Structure build(std::span<const Triangle> triangles) const { return structureType(structure).build(triangles, params); }
};

/// As a test's name may be: letters, digits, underscores.
std::string nameOf(const Variant& variant);
std::ostream& operator<<(std::ostream& out, const Variant& variant);

/// Every structure without options, then every value of every option: bounds by arities, builders by precisions and walks,
/// leaf sizes, depths, levels by densities.
std::vector<Variant> allVariants();

/// Of those, one for each layout that walks tell apart: the first.
std::vector<Variant> walkVariants();

}  // namespace raig::test

/// The structures of host/structures/registry.def in all their forms: what is gone through where something holds for every
/// structure.
#pragma once

#include "structures/structure.hpp"

#include <string>
#include <vector>

namespace raig {

/// A structure with options.
struct Variant {
    std::string structure;
    BuildParams params;

    Structure build(std::span<const Triangle> triangles) const { return structureType(structure).build(triangles, params); }
};

/// Its options in one word: letters, digits, underscores.
std::string nameOf(const Variant& variant);

/// Every structure without options, then every value of every option: bounds by arities, builders by precisions and walks,
/// leaf sizes, depths, levels by densities. Of leaf sizes by builders, arities and precisions, some; `thorough`: all.
std::vector<Variant> allVariants(bool thorough);

/// Of those, one for each layout that walks tell apart: the first.
std::vector<Variant> walkVariants();

}  // namespace raig

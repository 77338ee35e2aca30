#include "measure/variants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace raig {

namespace {

void addBvhs(std::vector<Variant>& variants, bool thorough) {
    variants.push_back({"bvh", {.walk = "skip"}});
    variants.push_back({"bvh", {.walk = "octants", .precision = 16, .maxLeaf = 1}});
    variants.push_back({"bvh", {.walk = "octants", .precision = 32, .maxLeaf = 15}});
    for (const char* build : {"median", "binned", "sweep", "sbvh", "lbvh"})
        for (const uint32_t precision : {16, 32}) variants.push_back({"bvh", {.build = build, .precision = precision}});
    for (const char* bound : {"aabb", "sphere", "obb", "kdop"})
        for (const uint32_t arity : {2, 4, 8}) variants.push_back({"bvh", {.bound = bound, .arity = arity}});
    for (const uint32_t arity : {2, 4, 8})
        for (const uint32_t precision : {32, 16, 8})
            variants.push_back({"bvh", {.walk = "trail", .arity = arity, .precision = precision}});
    for (const char* build : {"median", "sweep", "sbvh", "lbvh"})
        for (const uint32_t arity : {2, 4, 8})
            for (const uint32_t precision : {32, 16, 8}) {
                // Unless all are wanted, one or three of these nine.
                const bool chosen = arity * precision == 64 && (arity == 8 || std::string_view(build) == "sbvh");
                if (chosen || thorough)
                    variants.push_back(
                        {"bvh", {.build = build, .walk = "trail", .arity = arity, .precision = precision, .maxLeaf = 1}});
            }
    variants.push_back({"bvh", {.build = "sbvh", .walk = "skip", .arity = 8}});
    variants.push_back({"bvh", {.build = "sbvh", .bound = "obb", .arity = 4}});
}

void addSpacePartitions(std::vector<Variant>& variants) {
    variants.push_back({"octree", {.maxLeaf = 1, .maxTreeDepth = 5}});
    for (const char* build : {"sah", "median"})
        for (const char* walk : {"short-stack", "restart"}) variants.push_back({"kdtree", {.build = build, .walk = walk}});
    variants.push_back({"kdtree", {.walk = "restart", .maxLeaf = 30, .maxTreeDepth = 5}});
    variants.push_back({"bsp", {.maxLeaf = 1}});
    variants.push_back({"bsp", {.maxLeaf = 2, .maxTreeDepth = 64}});
    variants.push_back({"bsp", {.maxTreeDepth = 3}});
    for (const uint32_t levels : {1u, 2u}) {
        variants.push_back({"grid", {.levels = levels}});
        for (const float density : {0.05f, 30.0f}) variants.push_back({"grid", {.gridDensity = density, .levels = levels}});
    }
    variants.push_back({"grid", {.gridDensity = 0.001f, .levels = 2, .nestsGrids = true}});
}

}  // namespace

std::string nameOf(const Variant& variant) {
    const BuildParams& p = variant.params;
    std::string name = variant.structure + "_" + p.walk;
    std::replace(name.begin(), name.end(), '-', '_');
    if (!p.build.empty()) name += "_" + p.build;
    if (!p.bound.empty()) name += "_" + p.bound;
    if (p.arity > 0) name += fmt::format("_arity{}", p.arity);
    if (p.maxTreeDepth > 0) name += fmt::format("_depth{}", p.maxTreeDepth);
    if (p.precision > 0) name += fmt::format("_{}bit", p.precision);
    if (p.nestsGrids) name += "_nested";
    if (p.levels > 0) name += fmt::format("_levels{}", p.levels);
    if (p.gridDensity > 0.0f) name += p.gridDensity < 1.0f ? "_sparse" : "_dense";
    if (p.maxLeaf > 0) name += fmt::format("_leaf{}", p.maxLeaf);
    return name;
}

std::vector<Variant> allVariants(bool thorough) {
    std::vector<Variant> variants;
    for (const StructureType& type : structureTypes()) variants.push_back({std::string(type.name), {}});
    addBvhs(variants, thorough);
    addSpacePartitions(variants);
    return variants;
}

std::vector<Variant> walkVariants() {
    const Triangle one{vec3(0), vec3(1, 0, 0), vec3(0, 1, 1)};
    std::set<std::pair<std::string, uint32_t>> seen;
    std::vector<Variant> result;
    for (const Variant& variant : allVariants(/* thorough= */ false))
        if (seen.insert({variant.structure, variant.build(std::span(&one, 1)).header.walk}).second)
            result.push_back(variant);
    return result;
}

}  // namespace raig

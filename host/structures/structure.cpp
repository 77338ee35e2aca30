#include "structures/structure.hpp"

#include "all_structures.hpp"
#include "base/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace raig {

namespace {

const StructureType types[] = {
#define RAIG_STRUCTURE(name) {#name, name::build, name::findFault},
#include "structures/registry.def"
#undef RAIG_STRUCTURE
};

uvec4 texel(const vec3& corner, uint32_t word) {
    return {std::bit_cast<uint32_t>(corner.x), std::bit_cast<uint32_t>(corner.y), std::bit_cast<uint32_t>(corner.z), word};
}

vec3 corner(const uvec4& texel) {
    return {std::bit_cast<float>(texel.x), std::bit_cast<float>(texel.y), std::bit_cast<float>(texel.z)};
}

}  // namespace

void Structure::markSeeThrough(std::span<const uint8_t> seeThrough) {
    for (size_t i = 0; i < triangles.size(); i += shared::TRIANGLE_STRIDE) {
        const uint32_t id = triangles[i].w;
        RAIG_CHECK_OP(id, <, seeThrough.size());
        triangles[i + 1].w = seeThrough[id] != 0 ? shared::TRIANGLE_SEE_THROUGH : 0;
    }
}

std::span<const StructureType> structureTypes() {
    return types;
}

const StructureType& structureType(std::string_view name) {
    std::string names;
    for (const StructureType& type : types) {
        if (type.name == name) return type;
        names += (names.empty() ? "" : ", ") + std::string(type.name);
    }
    throw usageError("--accel {}: no such structure; there are {}", name, names);
}

void refuseOtherOptions(const BuildParams& params, std::string_view structure, std::initializer_list<std::string_view> offered) {
    const std::pair<std::string_view, bool> given[] = {
        {"--build", !params.build.empty()},          {"--walk", params.walk != "auto"},
        {"--bound", !params.bound.empty()},          {"--arity", params.arity != 0},
        {"--precision", params.precision != 0},
        {"--max-leaf", params.maxLeaf != 0},         {"--max-tree-depth", params.maxTreeDepth != 0},
        {"--grid-density", params.gridDensity != 0}, {"--levels", params.levels != 0},
    };
    for (const auto& [option, isGiven] : given)
        if (isGiven && std::find(offered.begin(), offered.end(), option) == offered.end())
            throw usageError("{}: {} has no such option; leave it out", option, structure);
}

float unitOf(const Box& bounds) {
    if (bounds.empty()) return 1.0f;
    float largest = 0.0f;
    for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis])});
    return std::ldexp(1.0f, -std::clamp(std::ilogb(largest), -120, 62));
}

void writeReference(std::vector<uvec4>& references, size_t index, const Triangle& triangle, uint32_t id, float unit) {
    uvec4* texels = references.data() + index * shared::TRIANGLE_STRIDE;
    texels[0] = texel(triangle.a * unit, id);
    texels[1] = texel(triangle.b * unit, 0);
    texels[2] = texel(triangle.c * unit, 0);
}

Triangle referencedTriangle(const Structure& structure, uint64_t index) {
    const uvec4* texels = structure.triangles.data() + index * shared::TRIANGLE_STRIDE;
    return {corner(texels[0]), corner(texels[1]), corner(texels[2])};
}

uint32_t referencedId(const Structure& structure, uint64_t index) {
    return structure.triangles[index * shared::TRIANGLE_STRIDE].w;
}

bool refersTo(const Structure& structure, uint64_t index, const Triangle& triangle) {
    const Triangle referred = referencedTriangle(structure, index);
    const float unit = structure.header.unit;
    return referred.a == triangle.a * unit && referred.b == triangle.b * unit && referred.c == triangle.c * unit;
}

StructureHeader emptyHeader() {
    StructureHeader header{};
    header.lo = vec3(1.0f);
    header.hi = vec3(-1.0f);
    header.unit = 1.0f;
    return header;
}

}  // namespace raig

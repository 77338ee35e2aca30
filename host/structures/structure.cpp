#include "structures/structure.hpp"

#include "all_structures.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

namespace raig {

namespace {

const StructureType types[] = {
#define RAIG_STRUCTURE(name) {#name, name::build, name::findFault},
#include "structures/registry.def"
#undef RAIG_STRUCTURE
};

/// An option that differs from its default, and its value.
struct GivenOption {
    std::string_view name;
    std::string value;
};

/// The one list of all options.
std::vector<GivenOption> givenOptions(const BuildParams& params) {
    const BuildParams defaults;
    std::vector<GivenOption> given;
    const auto add = [&](std::string_view name, const auto& value, const auto& byDefault) {
        if (value != byDefault) given.push_back({name, fmt::format("{}", value)});
    };
    constexpr double mebibyte = 1 << 20;
    add("--build", params.build, defaults.build);
    add("--walk", params.walk, defaults.walk);
    add("--bound", params.bound, defaults.bound);
    add("--arity", params.arity, defaults.arity);
    add("--precision", params.precision, defaults.precision);
    add("--max-leaf", params.maxLeaf, defaults.maxLeaf);
    add("--max-tree-depth", params.maxTreeDepth, defaults.maxTreeDepth);
    add("--grid-density", params.gridDensity, defaults.gridDensity);
    add("--levels", params.levels, defaults.levels);
    add("--memory-budget", params.memoryBudget / mebibyte, defaults.memoryBudget / mebibyte);
    return given;
}

uvec4 texel(const vec3& corner, uint32_t word) {
    return {std::bit_cast<uint32_t>(corner.x), std::bit_cast<uint32_t>(corner.y), std::bit_cast<uint32_t>(corner.z), word};
}

vec3 corner(const uvec4& texel) {
    return {std::bit_cast<float>(texel.x), std::bit_cast<float>(texel.y), std::bit_cast<float>(texel.z)};
}

}  // namespace

Box Primitive::box() const {
    if (isSphere()) return sphereBox(a, b.x);
    Box box;
    box.grow(a);
    box.grow(b);
    box.grow(c);
    return box;
}

bool Structure::hasSpheres() const {
    std::atomic<bool> found = false;
    parallelFor(triangles.size() / shared::TRIANGLE_STRIDE, 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end && !found; ++i)
            if (referencedPrimitive(*this, i).isSphere()) found = true;
    });
    return found;
}

std::string_view Structure::walkFile() const {
    static constexpr std::string_view trails[] = {"bvh_trail2", "bvh_trail4", "bvh_trail8"};
    if (name == "grid" && header.walk == shared::WALK_NESTED_GRID) return "grid_nested";
    return name == "bvh" && header.walk >= shared::WALK_TRAIL ? trails[(header.walk - shared::WALK_TRAIL) % 3]
                                                              : std::string_view(name);
}

void Structure::markSeeThrough(std::span<const uint8_t> seeThrough) {
    RAIG_CHECK(!isInstanced());
    markSeeThrough([&](uint32_t id) {
        RAIG_CHECK_OP(id, <, seeThrough.size());
        return seeThrough[id] != 0;
    });
}

void Structure::markSeeThrough(const std::function<bool(uint32_t)>& isSeeThrough, uint64_t first, uint64_t count) {
    const uint64_t all = triangles.size() / shared::TRIANGLE_STRIDE;
    for (uint64_t i = first; i < first + std::min(count, all - first); ++i) {
        uvec4* reference = &triangles[i * shared::TRIANGLE_STRIDE];
        uint32_t& flags = reference[1].w;
        flags = (flags & shared::TRIANGLE_SPHERE) | (isSeeThrough(reference[0].w) ? shared::TRIANGLE_SEE_THROUGH : 0);
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

std::string describeOptions(const BuildParams& params) {
    std::string text;
    for (const auto& [name, value] : givenOptions(params))
        text += fmt::format("{}{} {}", text.empty() ? "" : " ", name, value);
    return text;
}

void refuseOtherOptions(const BuildParams& params, std::string_view structure,
                        std::initializer_list<std::string_view> offered) {
    for (const auto& [name, value] : givenOptions(params))
        if (name != "--memory-budget" && std::find(offered.begin(), offered.end(), name) == offered.end())
            throw usageError("{}: {} has no such option; leave it out", name, structure);
}

float unitOf(const Box& bounds) {
    if (bounds.empty()) return 1.0f;
    float largest = 0.0f;
    for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis])});
    return std::ldexp(1.0f, -std::clamp(std::ilogb(largest), -120, 62));
}

void writeReference(std::vector<uvec4>& references, size_t index, const Primitive& primitive, uint32_t id, float unit) {
    uvec4* texels = references.data() + index * shared::TRIANGLE_STRIDE;
    const Primitive scaled = primitive.scaled(unit);
    texels[0] = texel(scaled.a, id);
    texels[1] = texel(scaled.b, primitive.isSphere() ? shared::TRIANGLE_SPHERE : 0);
    texels[2] = texel(scaled.c, 0);
}

Primitive referencedPrimitive(const Structure& structure, uint64_t index) {
    const uvec4* texels = structure.triangles.data() + index * shared::TRIANGLE_STRIDE;
    const bool sphere = (texels[1].w & shared::TRIANGLE_SPHERE) != 0;
    return {corner(texels[0]), corner(texels[1]), corner(texels[2]),
            sphere ? PrimitiveKind::sphere : PrimitiveKind::triangle};
}

uint32_t referencedId(const Structure& structure, uint64_t index) {
    return structure.triangles[index * shared::TRIANGLE_STRIDE].w;
}

bool refersTo(const Structure& structure, uint64_t index, const Primitive& primitive) {
    const Primitive referred = referencedPrimitive(structure, index), wanted = primitive.scaled(structure.header.unit);
    return referred.kind == wanted.kind && referred.a == wanted.a && referred.b == wanted.b && referred.c == wanted.c;
}

StructureHeader emptyHeader() {
    StructureHeader header{};
    header.lo = vec3(1.0f);
    header.hi = vec3(-1.0f);
    header.unit = 1.0f;
    return header;
}

}  // namespace raig

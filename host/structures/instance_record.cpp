#include "structures/instance_record.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace raig {

namespace {

/// Beyond this, rounding in double precision counts: the terms of a determinant are so much larger than it.
constexpr double mostCancellation = 0x1p20;

std::array<dvec4, 3> rowsOf(const shared::Placement& m) { return {dvec4(m.x), dvec4(m.y), dvec4(m.z)}; }

uvec4 texel(const dvec3& v, uint32_t word) {
    const vec3 f(v);
    return {std::bit_cast<uint32_t>(f.x), std::bit_cast<uint32_t>(f.y), std::bit_cast<uint32_t>(f.z), word};
}

uint32_t bits(double x) { return std::bit_cast<uint32_t>(static_cast<float>(x)); }

/// Rounded up, whatever the rounding.
float atLeast(double x) { return static_cast<float>(x * (1.0 + 0x1p-20)); }

/// Rows of the cofactors' transpose over the determinant, and of the same with all terms positive.
struct Inverse {
    std::array<dvec3, 3> rows, magnitudes;
    bool exists = false;
};

Inverse invert(const std::array<dvec4, 3>& m) {
    const auto minor = [&](int i, int j, double sign) {
        const int r0 = (i + 1) % 3, r1 = (i + 2) % 3, c0 = (j + 1) % 3, c1 = (j + 2) % 3;
        return sign < 0.0 ? m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0]
                          : std::abs(m[r0][c0] * m[r1][c1]) + std::abs(m[r0][c1] * m[r1][c0]);
    };
    double determinant = 0.0, terms = 0.0;
    for (int j = 0; j < 3; ++j) {
        determinant += m[0][j] * minor(0, j, -1.0);
        terms += std::abs(m[0][j]) * minor(0, j, 1.0);
    }
    Inverse inverse;
    inverse.exists = std::isfinite(terms) && terms <= mostCancellation * std::abs(determinant) && determinant != 0.0;
    if (!inverse.exists) return inverse;
    for (int k = 0; k < 3; ++k)
        for (int r = 0; r < 3; ++r) {
            inverse.rows[k][r] = minor(r, k, -1.0) / determinant;
            inverse.magnitudes[k][r] = minor(r, k, 1.0) / std::abs(determinant);
        }
    return inverse;
}

/// True for a row that only multiplies one coordinate by a power of two.
bool placesExactly(const dvec4& row) {
    int others = row.w != 0.0 ? 2 : 0;
    double entry = 0.0;
    for (int k = 0; k < 3; ++k)
        if (row[k] != 0.0) ++others, entry = row[k];
    int exponent = 0;
    return others <= 1 && std::abs(std::frexp(entry, &exponent)) == 0.5;
}

}  // namespace

shared::Placement betweenUnits(const shared::Placement& m, float bottomUnit, float sceneUnit) {
    const double linear = double{sceneUnit} / bottomUnit;
    const auto row = [&](const vec4& r) { return vec4(dvec4(r) * dvec4(linear, linear, linear, sceneUnit)); };
    return {row(m.x), row(m.y), row(m.z)};
}

bool isExact(const shared::Placement& m, const shared::Placement& inner, float bottomUnit, float sceneUnit) {
    const double linear = double{sceneUnit} / bottomUnit;
    const auto row = [&](const vec4& r, const vec4& got) {
        const dvec4 exact = dvec4(r) * dvec4(linear, linear, linear, sceneUnit);
        bool same = true;
        for (int i = 0; i < 4; ++i) same = same && exact[i] == got[i] && (got[i] == 0.0f || std::isnormal(got[i]));
        return same;
    };
    return row(m.x, inner.x) && row(m.y, inner.y) && row(m.z, inner.z);
}

InstanceSpace instanceSpace(const shared::Placement& inner, const Box& bounds, const vec3& at) {
    const std::array<dvec4, 3> m = rowsOf(inner);
    const Inverse inverse = invert(m);
    InstanceSpace space;
    if (!inverse.exists) return space;
    space.inverse = inverse.rows;
    const dvec3 largest = glm::max(glm::abs(dvec3(bounds.lo)), glm::abs(dvec3(bounds.hi)));
    dvec3 placed;  // A of shaders/instances.glsl: the largest magnitudes that placing sums up, where that rounds
    for (int r = 0; r < 3; ++r)
        placed[r] = placesExactly(m[r]) ? 0.0 : glm::dot(glm::abs(dvec3(m[r])), largest) + std::abs(m[r].w);
    double farthest = 0.0, blurred = 0.0;
    for (int k = 0; k < 3; ++k) {
        const dvec3 magnitude = glm::abs(inverse.rows[k]);
        space.corner[k] = glm::dot(inverse.rows[k], dvec3(at) - dvec3(m[0].w, m[1].w, m[2].w));
        // In double, an entry is wrong by 2^-50 of its terms' magnitudes, and by 2^-30 for the determinant at most.
        const dvec3 padded = magnitude * (1.0 + 0x1p-6) + inverse.magnitudes[k] * 0x1p-20;
        space.spread = std::max(space.spread, padded.x + padded.y + padded.z);
        blurred = std::max(blurred, glm::dot(padded, placed));
        farthest = std::max(farthest, std::abs(space.corner[k]));
    }
    space.blur = (2.0 * farthest + 4.01 * blurred) / 53.0 * 1.01;
    space.invertible = std::isfinite(space.spread) && std::isfinite(space.blur) && space.spread <= 0x1p100 &&
                       space.spread >= 0x1p-100 && space.blur <= 0x1p20;
    return space;
}

// A bottom may be kept if the slack of a ray from a scene's extent away is less than 1/256 of the bottom's size; or, where
// things are so small in the scene that it is more, if it is no more than 64 times that of the scene written out, which
// every structure has to stand: rotations and like scales widen it some 5 times, a scale of 10 along one axis up to 50
// times.
bool fits(const shared::Placement& inner, const Box& bounds, float extent) {
    if (bounds.empty()) return false;
    const std::array<dvec4, 3> m = rowsOf(inner);
    const dvec3 middle = 0.5 * (dvec3(bounds.lo) + dvec3(bounds.hi));
    dvec3 at;
    double norm = 0.0;
    for (int r = 0; r < 3; ++r) {
        at[r] = glm::dot(dvec3(m[r]), middle) + m[r].w;
        norm = std::max(norm, std::abs(m[r].x) + std::abs(m[r].y) + std::abs(m[r].z));
    }
    const InstanceSpace space = instanceSpace(inner, bounds, vec3(at));
    if (!space.invertible) return false;
    const vec3 size = bounds.extent();
    const double own = std::max({size.x, size.y, size.z});
    const double unit = own + 1.3125 * extent * space.spread + space.blur;  // of slack: u times this
    const bool small = 64.0 * 0x1p-24 * unit <= own / 256.0;
    return small || norm * unit <= 64.0 * extent;
}

void writeInstance(uvec4* record, const shared::Placement& inner, const InstanceSpace& space, const vec3& at,
                   uint32_t firstId, uint32_t bottomAt, bool mirrored) {
    const std::array<dvec4, 3> m = rowsOf(inner);
    for (int i = 0; i < 3; ++i) {
        record[i] = texel(dvec3(m[i]), bits(m[i].w));
        record[3 + i] = texel(space.inverse[i], bits(space.corner[i]));
    }
    record[6] = texel(dvec3(at), firstId);
    record[7] = {bottomAt, mirrored ? shared::INSTANCE_MIRRORS : 0u, std::bit_cast<uint32_t>(atLeast(space.spread)),
                 std::bit_cast<uint32_t>(atLeast(space.blur))};
}

}  // namespace raig

#include "support/standard_rays.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace raig::test {

namespace {

constexpr Real pi = std::numbers::pi_v<Real>;

Vector operator+(const Vector& a, const Vector& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vector operator-(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector operator*(Real s, const Vector& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
Real dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Real length(const Vector& a) {
    return std::sqrt(dot(a, a));
}
Vector unit(const Vector& a) {
    return (1 / length(a)) * a;
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Frame {
    Vector eye, f, r, u;
    Real tangent;  ///< of half the field of view, 22.5 degrees
};

Frame frameOf(const std::vector<Corners>& triangles, const Vector& low, const Vector& high) {
    const Vector c = Real(0.5) * (low + high), towards = unit({0.5L, 0.35L, 1.0L});
    Frame frame;
    frame.tangent = std::tan(pi / 8);
    frame.f = Real(-1) * towards;
    frame.r = unit(cross(frame.f, {0, 1, 0}));
    frame.u = cross(frame.r, frame.f);
    Real distance = 0;
    for (const Corners& triangle : triangles)
        for (const Vector& p : triangle) {
            bool isFramed = true;
            for (int axis = 0; axis < 3; ++axis) isFramed = isFramed && low[axis] <= p[axis] && p[axis] <= high[axis];
            if (!isFramed) continue;
            const Vector v = p - c;
            const Real across = std::max(std::abs(dot(v, frame.r)), std::abs(dot(v, frame.u)));
            distance = std::max(distance, across / (0.95L * frame.tangent) - dot(v, frame.f));
        }
    frame.eye = c + distance * towards;
    return frame;
}

Vector through(const Frame& frame, uint32_t i, uint32_t j, uint32_t side) {
    const Real sx = (2 * (i + 0.5L) / side - 1) * frame.tangent, sy = (1 - 2 * (j + 0.5L) / side) * frame.tangent;
    return unit(frame.f + sx * frame.r + sy * frame.u);
}

/// The triangle met first, edges included, by the volumes that the ray spans with its edges.
const Corners* firstMet(const std::vector<Corners>& triangles, const Vector& eye, const Vector& d) {
    const Corners* first = nullptr;
    Real nearest = 0;
    for (const Corners& triangle : triangles) {
        const Vector a = triangle[0] - eye, b = triangle[1] - eye, c = triangle[2] - eye;
        const Real x = dot(d, cross(a, b)), y = dot(d, cross(b, c)), z = dot(d, cross(c, a));
        if (!((x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0)) || x + y + z == 0) continue;
        const Real t = dot(a, cross(b, c)) / (x + y + z);
        if (t < 0 || (first && t >= nearest)) continue;
        first = &triangle;
        nearest = t;
    }
    return first;
}

uint32_t hash(uint32_t x) {
    const uint32_t state = 747796405u * x + 2891336453u;
    const uint32_t word = 277803737u * ((state >> ((state >> 28u) + 4u)) ^ state);
    return (word >> 22u) ^ word;
}

/// The basis of Duff et al. 2017 with its two cases written out: s = 1 or -1, s + z = s (1 + |z|).
Vector cosineDirection(const Vector& n, uint32_t pixel) {
    const Real u1 = hash(2 * pixel) / 4294967296.0L, u2 = hash(2 * pixel + 1) / 4294967296.0L;
    const auto [x, y, z] = n;
    const Real s = std::signbit(z) ? -1 : 1, k = 1 / (1 + std::abs(z));
    const Vector tangent = {1 - x * x * k, -x * y * k, -s * x}, bitangent = {-s * x * y * k, s * (1 - y * y * k), -y};
    const Real radius = std::sqrt(u1), angle = 2 * pi * u2;
    return radius * std::cos(angle) * tangent + radius * std::sin(angle) * bitangent + std::sqrt(1 - u1) * n;
}

void addSecondary(ExactSets& sets, const Frame& frame, const Corners& met, const Vector& d, uint32_t pixel,
                  const Vector& light) {
    const Vector across = cross(met[1] - met[0], met[2] - met[0]);
    const Real t = dot(across, met[0] - frame.eye) / dot(across, d);
    const Vector point = frame.eye + t * d;
    Vector n = unit(across);
    if (dot(n, frame.eye - point) < 0) n = Real(-1) * n;
    ++(n[2] > 0 ? sets.frontal : sets.averted);
    const Vector start = point + 2e-5L * t * n, toLight = light - start;
    if (dot(n, light - point) > 0) sets.shadow.push_back({start, unit(toLight), length(toLight) * (1 - 1e-4L)});
    sets.diffuse.push_back({start, cosineDirection(n, pixel), 1e30L});
    sets.specular.push_back({start, unit(d - 2 * dot(d, n) * n), 1e30L});
}

}  // namespace

ExactSets exactSets(const std::vector<Corners>& triangles, const Vector& low, const Vector& high, uint32_t side) {
    const Frame frame = frameOf(triangles, low, high);
    const Vector light = Real(0.5) * (low + high) + 3 * (length(high - low) / 2) * unit({-0.6L, 1.0L, 0.8L});
    ExactSets sets;
    sets.eye = frame.eye;
    for (uint32_t tileRow = 0; tileRow < side / 8; ++tileRow)
        for (uint32_t tileColumn = 0; tileColumn < side / 8; ++tileColumn)
            for (uint32_t m = 0; m < 64; ++m) {
                const uint32_t i = 8 * tileColumn + ((m & 1) | (m & 4) >> 1 | (m & 16) >> 2);
                const uint32_t j = 8 * tileRow + ((m & 2) >> 1 | (m & 8) >> 2 | (m & 32) >> 3);
                const Vector d = through(frame, i, j, side);
                sets.primary.push_back({frame.eye, d, 1e30L});
                if (const Corners* const met = firstMet(triangles, frame.eye, d))
                    addSecondary(sets, frame, *met, d, j * side + i, light);
            }
    return sets;
}

}  // namespace raig::test

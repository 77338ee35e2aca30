/// Planes of a bsp, and polygons and cells cut by them. Coordinates are relative to the scene's lower bounds, in its unit.
#pragma once

#include "base/vectors.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace raig::bsp {

constexpr uint32_t leafBit = 1u << 31;
constexpr uint32_t moreBit = 1u << 30;     // of a leaf
constexpr uint32_t linkedBit = 1u << 29;   // of a leaf
constexpr uint32_t noBelowBit = 1u << 30;  // of an inner node
constexpr uint32_t noAboveBit = 1u << 29;
constexpr uint32_t indexBits = noAboveBit - 1;
constexpr uint32_t mostLevels = 64;  // bits of a walk's trail

/// How far a triangle may stick out of a cell that it is not in, for a scene of the largest extent 1: what the walk's slack
/// has room for (shaders/structures/bsp.glsl).
constexpr double tolerance = 14 * 0x1p-24;

/// The points with normal . x == distance. Exactly what the walk computes with: components are multiples of 2^-20, and the
/// sum of their magnitudes is at most 1.
struct Plane {
    std::array<int32_t, 3> steps{};  ///< the normal, in steps of 2^-20
    float distance = 0.0f;

    dvec3 normal() const { return dvec3(steps[0], steps[1], steps[2]) * 0x1p-20; }
    /// Signed, in the normal's length; to a few parts in 2^53 of the largest coordinate.
    double to(const dvec3& point) const { return glm::dot(normal(), point) - double{distance}; }

    static Plane alongAxis(int axis, double coordinate);
    /// The one nearest to lying at right angles to `normal` and midway among the points. Nothing for a normal of no length.
    static std::optional<Plane> across(const dvec3& normal, std::span<const dvec3> points);

    /// As a node, with word w of it; and back.
    uvec4 encoded(uint32_t word) const;
    static Plane decoded(const uvec4& node);
};

/// Appends to `result` the corners of a convex polygon's part on one side (below: -1, above: 1) of the plane moved out by
/// `margin`. It contains all of the part on that side of the plane itself, if the margin exceeds the rounding.
void clip(std::span<const dvec3> polygon, const Plane& plane, double side, double margin, std::vector<dvec3>& result);

/// A convex cell: its faces' corners, face after face, anticlockwise from outside.
class Cell {
public:
    /// One without faces.
    Cell() = default;
    /// A box from 0 to `size`.
    explicit Cell(const dvec3& size);

    double area() const;
    /// The areas of the two parts that a plane cuts the cell into: of one that it does not reach, 0. Without building them:
    /// the vector areas of a closed surface add up to nothing, so the cut's is that of the faces on one side.
    std::array<double, 2> areas(const Plane& plane) const;
    /// The part below (-1) or above (1). Good for areas, to a few parts in 10^12; nothing else depends on it.
    Cell part(const Plane& plane, double side) const;
    /// The box around it.
    void bounds(dvec3& lo, dvec3& hi) const;

private:
    void endFace();
    void addCut(std::vector<dvec3> corners, const dvec3& outwards);

    std::vector<dvec3> corners_;
    std::vector<uint32_t> ends_;      // of the faces
    std::vector<dvec3> faceVectors_;  // their areas, times their normals
    std::vector<double> faceAreas_;
};

}  // namespace raig::bsp

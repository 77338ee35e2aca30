/// The hits of rays in exact arithmetic, edges inclusive: what the walks in single precision are judged by. Shares no code
/// with them, nor with host/reference/.
#pragma once

#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace raig::hard {

#ifdef __SIZEOF_FLOAT128__
using Exact = __float128;
#else
using Exact = long double;
#endif

/// How a hit found in floats compares with the exact one (the catalogue of hard cases, section 6.1).
enum class Verdict { same, tie, missed, phantom, wrong };

/// What the oracle makes of one ray's hit.
struct Judgement {
    Verdict verdict = Verdict::same;
    bool sound = true;  ///< the hit is no farther from its triangle than rounding explains
    bool open = false;  ///< rounding may decide the answer; told of those only whose verdict is missed, phantom or wrong

    bool isFault() const { return !sound || (!open && verdict != Verdict::same && verdict != Verdict::tie); }
};

/// "o (..) d (..) t [..]" and "primitive .. t .. u .. v ..", with all digits.
std::string describe(const Ray& ray);
std::string describe(const Hit& hit);

/// Tries every triangle and sphere for each ray, in arithmetic of 113 bits or more. Differences of floats are exact there
/// unless 89 binary orders of magnitude apart; where roundings of the products leave a sign open, the value counts as zero,
/// so as on the edge.
///
/// Rules     A triangle has its edges and corners, a sphere its surface, with the points where rays only touch it. A
///           triangle is not hit by a ray in its plane, nor if a corner is not finite or lies beyond 1.844e18, nor is a
///           sphere of which that holds for any point, or without a radius. Nothing is hit by a ray with a component that is
///           not finite, without a direction, with tMin > tMax or tMax < 0. The nearest hit in [max(tMin, 0), tMax] counts;
///           at equal distances, the lowest index.
/// Tie       Let u = 2^-24, M the largest distance along an axis from the origin to the bounds, and the direction be scaled
///           to a largest component of magnitude [1, 2). The walks' contract (shaders/intersect.glsl) is that the point at
///           distance t is within 64 u M, along each axis, of the triangle that is hit: so t may differ from the exact one,
///           in that scale, by 64 u M |n|_1 / |n . d|, n the normal. A hit of another triangle is a tie if the distance
///           differs from the exact one by no more than that of both; one of the same triangle, and no more than that,
///           is the same; and one that differs by more is wrong. Of a sphere, the distance may differ from the exact one by
///           as much as the point can move along the ray while it is no farther than sqrt(3) 64 u M from the surface.
/// Sound     Any hit must lie within sqrt(3) 64 u M of its triangle or sphere, whatever the ray.
/// Open      A ray is open if, no farther than the exact hit, it passes an edge by less than 32 u M (11 u M by which corners
///           may be misplaced, along each of two axes, and the roundings of the edge functions), and the triangles at this
///           edge do not reach beyond that on both sides of it, as seen along the ray. Or if it passes a sphere's silhouette
///           by less than that, or a hit's distance differs by less than its rounding from tMin or tMax. There, rounding may
///           decide either way: such rays are counted, and judged only for soundness; or as all others, if `strict` is asked
///           for.
class Oracle {
public:
    explicit Oracle(std::span<const Primitive> primitives);

    /// The exact hit: t, u and v rounded.
    Hit closest(const Ray& ray) const;

    /// All triangles that are hit at the exact distance: more than one where the ray meets an edge or a corner that they
    /// share. By index; none if nothing is hit.
    std::vector<uint32_t> allClosest(const Ray& ray) const;

    bool isOpen(const Ray& ray) const;

    /// Judges one hit; `strict` as above.
    Judgement judge(const Ray& ray, const Hit& hit, bool strict) const;

private:
    struct Vector {
        Exact x, y, z;
    };
    struct Meeting {
        bool hits = false;
        Exact t = 0, u = 0, v = 0;
        double give = 0.0;  ///< how much t may differ, by rounding
    };
    /// Where a ray's line meets a sphere, and where it comes nearest to the centre.
    struct Crossing {
        bool meets = false;
        Exact first = 0, second = 0;  ///< distances, first <= second
        double nearest = 0.0;         ///< the distance along the ray at which it is nearest to the centre
        double off = 0.0;             ///< by how much it passes outside the surface there; inside, if negative
    };
    /// A ray, with what roundings of the walk are measured in.
    struct Seen {
        Ray ray;
        bool valid = false;
        double scale = 1.0;  ///< of the direction: times this, its largest component is in [1, 2)
        double unit = 0.0;   ///< u M
        int z = 0;           ///< the axis of the largest component
    };
    struct Edge {
        uint32_t from, to;             ///< of corners_
        std::vector<uint32_t> across;  ///< the third corners of its triangles
    };

    Seen seen(const Ray& ray) const;
    bool mayMeet(const Seen& seen, const Primitive& primitive) const;
    Meeting meet(const Seen& seen, const Primitive& primitive) const;
    Meeting meetTriangle(const Seen& seen, const Triangle& triangle) const;
    Meeting meetSphere(const Seen& seen, const Primitive& sphere) const;
    Crossing cross(const Seen& seen, const Primitive& sphere, double margin) const;
    double giveOf(const Seen& seen, const Primitive& sphere, Exact t) const;
    bool isOpenAt(const Seen& seen, const Primitive& primitive, double end) const;
    Verdict verdict(const Seen& seen, const Hit& got, bool& sound) const;
    bool isOpen(const Seen& seen) const;
    dvec3 sheared(const Seen& seen, const vec3& corner) const;
    uint32_t best(const Seen& seen, Meeting& meeting) const;

    std::vector<Primitive> primitives_;
    std::vector<uint8_t> usable_;
    Box bounds_;
    std::vector<vec3> corners_;
    std::vector<Edge> edges_;
};

}  // namespace raig::hard

/// Whether a primitive and a box overlap: where builders that cut space, not sets of primitives, put their references.
#pragma once

#include "structures/structure.hpp"

#include <array>

namespace raig {

/// One triangle, prepared to be tested against many boxes by the separating axes of two convex bodies: the box's three
/// normals, the triangle's, and the nine cross products of their edges. Or a sphere, which a box meets that has points at
/// its centre's distance: the nearest no farther, the farthest no nearer than the radius.
///
/// Conservative: primitive and box are closed, so touching counts; and no rounding ever separates two that touch. Any vector
/// is a valid axis, a rounded one too; what matters is only that projections onto it are disjoint by more than the
/// roundings of the projections, which is what is asked. So the answer is wrong only the harmless way, and only for boxes
/// nearer than some 2^-47 of the coordinates' magnitude (for a sliver: that over the sine of its smallest angle).
///
/// Requires corners and boxes with coordinates whose magnitude is at most 2^100, say.
/// Source: Akenine-Möller 2001, "Fast 3D Triangle-Box Overlap Testing"; Arvo 1990, "A Simple Method for Box-Sphere
/// Intersection Testing", hollow boxes and spheres.
class PrimitiveBoxTest {
public:
    explicit PrimitiveBoxTest(const Primitive& primitive);

    /// True if the box [lo, hi] and the primitive have a point in common. Requires lo <= hi. 60 multiplications at most.
    bool overlaps(const dvec3& lo, const dvec3& hi) const;

private:
    /// The triangle's extent along one axis.
    struct Span {
        double lo, hi;
    };
    /// Projects the corners; `axis` need not be of unit length.
    Span spanAlong(const dvec3& axis) const;
    bool separates(const dvec3& axis, const Span& span, const dvec3& centre, const dvec3& half,
                   const dvec3& magnitude) const;

    void prepareTriangle();
    void prepareSphere(const Primitive& sphere);
    bool meetsSphere(const dvec3& lo, const dvec3& hi) const;

    bool isSphere_;
    double radius_ = 0.0;  // then corners_[0] is the centre
    std::array<dvec3, 3> corners_;
    dvec3 lo_, hi_;
    dvec3 magnitude_;             // the largest of the corners' along each axis
    std::array<dvec3, 10> axes_;  // the normal, then the cross products
    std::array<Span, 10> spans_;
};

}  // namespace raig

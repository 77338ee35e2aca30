#include "structures/clip.hpp"
#include "base/random.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using namespace glm;

// Nothing of a triangle in a box is left out of its bounds, and the bounds hold little else.
TEST(Clip, BoundsThePartOfATriangleInABox) {
    Random random(9);
    for (int trial = 0; trial < 3000; ++trial) {
        const double size = std::pow(10.0, random.within(-4, 0));
        const vec3 centre = random.inCube(-0.9, 0.9);
        const Triangle t{centre + vec3(size * dvec3(random.inCube(-1, 1))),
                         centre + vec3(size * dvec3(random.inCube(-1, 1))),
                         centre + vec3(size * dvec3(random.inCube(-1, 1)))};
        Box box;
        box.grow(centre + vec3(size * dvec3(random.inCube(-1, 1))));
        box.grow(centre + vec3(size * dvec3(random.inCube(-1, 1))));
        const Box got = clippedBounds(t, box);
        EXPECT_TRUE(box.contains(got));
        dvec3 lo(10.0), hi(-10.0);
        constexpr int n = 150;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n - i; ++j) {
                const dvec3 p =
                    (double(i) * dvec3(t.a) + double(j) * dvec3(t.b) + double(n - i - j) * dvec3(t.c)) / double(n);
                if (!all(lessThanEqual(dvec3(box.lo), p)) || !all(lessThanEqual(p, dvec3(box.hi)))) continue;
                lo = min(lo, p);
                hi = max(hi, p);
            }
        if (lo.x > hi.x) continue;  // no sample in the box
        ASSERT_TRUE(all(lessThanEqual(dvec3(got.lo), lo)) && all(lessThanEqual(hi, dvec3(got.hi)))) << trial;
    }
    // A corner cut off: exactly half of each leg.
    const Box half = clippedBounds({vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}, {vec3(0.5f, 0, -1), vec3(1, 1, 1)});
    EXPECT_EQ(half.lo, vec3(0.5f, 0, 0));
    EXPECT_NEAR(half.hi.y, 0.5f, 1e-7f);
    EXPECT_EQ(half.hi.z, 0.0f);
    EXPECT_TRUE(clippedBounds({vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}, {vec3(0.6f, 0.6f, -1), vec3(1, 1, 1)}).empty());
}

}  // namespace
}  // namespace raig

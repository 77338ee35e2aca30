// Spheres one by one: the float test and the reference's against 113-bit arithmetic, and what builders take of them.
#include "base/parallel.hpp"
#include "rays/tracer.hpp"
#include "reference/sphere.hpp"
#include "structures/clip.hpp"
#include "structures/triangle_box.hpp"
#include "support/sphere_soups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace raig {
namespace {

__extension__ typedef __float128 Quad;

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr double u = 0x1p-24;

Quad rootOf(Quad x) {
    if (x <= 0) return 0;
    Quad root = std::sqrt(static_cast<double>(x));
    for (int i = 0; i < 3 && root > 0; ++i) root = (root + x / root) / 2;
    return root;
}

/// What a ray of floats and a sphere of floats have to do with each other.
struct Exact {
    Quad a = 0, b = 0, c = 0, radius;  // a t^2 - 2 b t + c = 0
    Exact(const Ray& ray, const Primitive& sphere) : radius(sphere.radius()) {
        for (int axis = 0; axis < 3; ++axis) {
            const Quad f = Quad(ray.origin[axis]) - Quad(sphere.centre()[axis]), d = ray.direction[axis];
            a += d * d;
            b -= f * d;
            c += f * f;
        }
        c -= radius * radius;
    }
    /// The nearest crossing in [0, inf).
    std::optional<double> nearest() const {
        const Quad rest = b * b - a * c;
        if (rest < 0) return std::nullopt;
        const Quad root = rootOf(rest), near = (b - root) / a, far = (b + root) / a;
        if (far < 0) return std::nullopt;
        return static_cast<double>(near >= 0 ? near : far);
    }
    /// How far the line passes the centre.
    double passes() const { return static_cast<double>(rootOf(std::max(Quad(0), c + radius * radius - b * b / a))); }
    /// How far the point at t is from the surface.
    double offset(double t) const {
        return static_cast<double>(rootOf(a * t * t - 2 * b * t + c + radius * radius) - radius);
    }
};

std::vector<Hit> traceOne(const Primitive& sphere, const std::vector<Ray>& rays) {
    const Structure structure = structureType("brute").build(std::vector{sphere}, {});
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    return hits;
}

Hit traceOne(const std::vector<Primitive>& primitives, const Ray& ray) {
    const Structure structure = structureType("brute").build(primitives, {});
    std::vector<Hit> hits(1);
    makeCpuTracer(structure)->trace(std::vector{ray}, hits, Query::closest);
    return hits[0];
}

/// The largest distance along an axis from the origin to the sphere's box: the M of shaders/intersect.glsl.
double reachOf(const Ray& ray, const Box& box) {
    const dvec3 lo = glm::abs(dvec3(box.lo) - dvec3(ray.origin)), hi = glm::abs(dvec3(box.hi) - dvec3(ray.origin));
    const dvec3 most = glm::max(lo, hi);
    return std::max({most.x, most.y, most.z});
}

// Hard case 51. The walks rely on 53 u M. In ten times as many rays the hits were 7 u M off the surface at most; t erred
// by 5.2 times what half a unit in the last place of centre, radius or origin changes it by (0.6 on average); and misses and
// phantoms were within 3 u M of tangency.
TEST(Spheres, AreHitWhereExactArithmeticHitsThem) {
    Random random(1);
    double worstOffset = 0.0, worstError = 0.0, worstTangency = 0.0;
    size_t rays = 0, hitCount = 0, missed = 0, phantoms = 0;
    for (const double scale : {1.0, 1e-13, 2e9})
        for (int i = 0; i < 60; ++i) {
            const vec3 centre = vec3(scale * dvec3(random.inCube(-1, 1)));
            const Primitive sphere =
                Primitive::sphere(centre, static_cast<float>(scale * std::pow(10.0, random.within(-3, 0))));
            std::vector<Ray> some;
            for (int j = 0; j < 1000; ++j) some.push_back(test::rayAtSphere(sphere, random));
            const std::vector<Hit> hits = traceOne(sphere, some);
            for (size_t j = 0; j < some.size(); ++j) {
                const Exact exact(some[j], sphere);
                const std::optional<double> want = exact.nearest();
                const bool hit = hits[j].primitive != NO_HIT;
                const double um = u * reachOf(some[j], sphere.box()), radius = sphere.radius();
                const double tangency = std::abs(exact.passes() - radius) / um;
                // Where the origin is on the surface, to rounding, it is on either side of it.
                const double side = std::abs(exact.offset(0.0)) / um;
                if (hit != want.has_value() && side > 8.0) {
                    (hit ? phantoms : missed) += 1;
                    worstTangency = std::max(worstTangency, tangency);
                }
                if (hit) worstOffset = std::max(worstOffset, std::abs(exact.offset(hits[j].t)) / um);
                if (hit && want && side > 8.0) {
                    const double length = std::sqrt(static_cast<double>(exact.a)), passes = exact.passes();
                    const double away = std::sqrt(static_cast<double>(exact.c) + radius * radius);
                    const double rest = std::sqrt(std::max(radius * radius - passes * passes, 1e-3 * radius * radius));
                    const double inherent = u * (away + radius) * (1.0 + passes / rest) / length;
                    const double ulp = std::nextafter(static_cast<float>(*want), inf) - static_cast<float>(*want);
                    const double error = std::abs(hits[j].t - *want) / std::max(ulp, inherent);
                    if (tangency > 2e-3 * radius / um) worstError = std::max(worstError, error);
                }
                hitCount += hit;
                ++rays;
            }
        }
    EXPECT_GT(hitCount, rays / 2);
    EXPECT_LT(worstOffset, 10.0) << "in u M, of which walks allow 53";
    EXPECT_LT(worstError, 6.0);
    EXPECT_LT(worstTangency, 6.0) << missed << " missed, " << phantoms << " phantoms";
    EXPECT_GT(missed + phantoms, 0u) << "no ray comes near enough to tangency to test anything";
}

TEST(Spheres, AreMetFromInsideInEveryDirection) {
    Random random(2);
    for (const double scale : {1e-13, 1.0, 2e9})
        for (const double depth : {1e-6, 1e-3, 0.5, 1.0}) {
            const Primitive sphere = Primitive::sphere(vec3(scale * dvec3(0.1, -0.2, 0.3)), static_cast<float>(0.8 * scale));
            std::vector<Ray> rays;
            for (int i = 0; i < 4000; ++i) {
                const dvec3 n = random.direction();
                dvec3 d = random.direction();
                if (i % 2 == 0) d -= glm::dot(d, n) * n;  // along the surface
                rays.push_back({vec3(dvec3(sphere.centre()) + sphere.radius() * (1.0 - depth) * n), 0.0f, vec3(d), inf});
            }
            for (const Hit& hit : traceOne(sphere, rays))
                ASSERT_TRUE(hit.primitive == 0 && hit.t >= 0.0f) << scale << ' ' << depth;
        }
}

// Hard case 51: from outside the largest is met first, from inside the smallest, whatever the rounding.
TEST(Spheres, AroundOneCentreComeInOrder) {
    std::vector<Primitive> shells;
    for (int i = 0; i < 50; ++i)
        shells.push_back(Primitive::sphere(vec3(0.3f, 0.1f, -0.2f), 1.0f + 4e-5f * static_cast<float>(i)));
    const Structure structure = structureType("bvh").build(shells, {});
    Random random(3);
    std::vector<Ray> rays;
    for (int i = 0; i < 20'000; ++i) rays.push_back(test::rayAtSphere(shells[i % 2 == 0 ? 0 : 49], random));
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    size_t outside = 0, inside = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        const double distance = glm::distance(dvec3(rays[i].origin), dvec3(shells[0].centre()));
        // From farther away, 4e-5 are less than a unit in the last place of t.
        if (distance > 1.01 && distance < 100.0 && hits[i].primitive != NO_HIT) {
            ASSERT_EQ(hits[i].primitive, 49u) << test::describe(rays[i]);
            ++outside;
        } else if (distance < 0.99) {
            ASSERT_EQ(hits[i].primitive, 0u) << test::describe(rays[i]);
            ++inside;
        }
    }
    EXPECT_GT(outside, 1000u);
    EXPECT_GT(inside, 1000u);
}

TEST(Spheres, AreHitAtBothEndsOfAClosedInterval) {
    const std::vector<Primitive> one = {Primitive::sphere(vec3(0), 1.0f)};
    const auto hitIn = [&](float tMin, float tMax) {
        const Hit hit = traceOne(one, {vec3(0, 0, -3), tMin, vec3(0, 0, 1), tMax});
        EXPECT_TRUE(hit.primitive == NO_HIT || (hit.u == 0.0f && hit.v == 0.0f));
        return hit.primitive == NO_HIT ? -1.0f : hit.t;
    };
    EXPECT_EQ(hitIn(0.0f, inf), 2.0f);
    EXPECT_EQ(hitIn(2.0f, 2.0f), 2.0f);
    EXPECT_EQ(hitIn(0.0f, std::nextafter(2.0f, 0.0f)), -1.0f);
    EXPECT_EQ(hitIn(std::nextafter(2.0f, 3.0f), inf), 4.0f);
    EXPECT_EQ(hitIn(4.0f, 4.0f), 4.0f);
    EXPECT_EQ(hitIn(std::nextafter(2.0f, 3.0f), std::nextafter(4.0f, 3.0f)), -1.0f);
    EXPECT_EQ(hitIn(std::nextafter(4.0f, 5.0f), inf), -1.0f);
    // Touched by a tangent, exactly.
    EXPECT_EQ(traceOne(one, {vec3(1, 0, -5), 0.0f, vec3(0, 0, 1), inf}).t, 5.0f);
    EXPECT_EQ(traceOne(one, {vec3(std::nextafter(1.0f, 2.0f), 0, -5), 0.0f, vec3(0, 0, 1), inf}).primitive, NO_HIT);
}

TEST(Spheres, ShareDistancesByTheLowestId) {
    const Primitive sphere = Primitive::sphere(vec3(0), 1.0f);
    const Triangle touching{vec3(-1, -1, -1), vec3(1, -1, -1), vec3(0, 1, -1)};
    const Ray ray{vec3(0, 0, -3), 0.0f, vec3(0, 0, 1), inf};
    for (const std::vector<Primitive>& primitives :
         {std::vector{sphere, touching}, std::vector{touching, sphere}, std::vector{sphere, sphere, touching}}) {
        const Hit hit = traceOne(primitives, ray);
        EXPECT_EQ(hit.primitive, 0u);
        EXPECT_EQ(hit.t, 2.0f);
    }
}

TEST(Spheres, HaveTheSmallestBoxOfFloatsAroundThem) {
    Random random(4);
    for (int i = 0; i < 100'000; ++i) {
        const auto centre = static_cast<float>(random.within(-1, 1) * std::pow(10.0, random.within(-12, 12)));
        const auto radius = static_cast<float>(std::pow(10.0, random.within(-12, 12)));  // sums of which fit 113 bits
        const Box box = sphereBox(vec3(centre), radius);
        const Quad lo = Quad(centre) - Quad(radius), hi = Quad(centre) + Quad(radius);
        ASSERT_TRUE(Quad(box.lo.x) <= lo && Quad(std::nextafter(box.lo.x, inf)) > lo) << centre << ' ' << radius;
        ASSERT_TRUE(Quad(box.hi.x) >= hi && Quad(std::nextafter(box.hi.x, -inf)) < hi) << centre << ' ' << radius;
    }
}

Box randomBox(Random& random, double size) {
    const dvec3 at(random.inCube(-1, 1));
    Box box;
    for (int i = 0; i < 2; ++i) box.grow(vec3(at + size * dvec3(random.inCube(-1, 1))));
    return box;
}

// Wherever the surface enters a box there is a part of it, with a box around it; where it clearly does not, there is none.
TEST(Spheres, MeetBoxesWhereTheirSurfaceDoes) {
    Random random(5);
    size_t met = 0, apart = 0, hollow = 0;
    for (int i = 0; i < 4000; ++i) {
        const Primitive sphere =
            Primitive::sphere(random.inCube(-1, 1), static_cast<float>(std::pow(10.0, random.within(-3, 0))));
        const Box box = randomBox(random, std::pow(10.0, random.within(-2, 0)));
        const Box part = clippedBounds(sphere, box);
        const bool overlaps = PrimitiveBoxTest(sphere).overlaps(dvec3(box.lo), dvec3(box.hi));
        EXPECT_TRUE(box.contains(part));
        const dvec3 centre(sphere.centre()), lo(box.lo), hi(box.hi);
        const double near = glm::distance(centre, glm::clamp(centre, lo, hi));
        const double far = glm::length(glm::max(glm::abs(lo - centre), glm::abs(hi - centre)));
        const double radius = sphere.radius();
        if (near > radius + 1e-12 || far < radius - 1e-12) {
            EXPECT_TRUE(part.empty() && !overlaps);
            (near > radius ? apart : hollow) += 1;
        }
        for (int j = 0; j < 300; ++j) {
            // On the surface, and, every other time, near the box.
            dvec3 way = random.direction();
            if (j % 2 == 0)
                way = glm::normalize(glm::mix(lo, hi, dvec3(random.unit(), random.unit(), random.unit())) - centre);
            const dvec3 p = centre + radius * way;
            if (glm::any(glm::lessThan(p, lo + 1e-14)) || glm::any(glm::greaterThan(p, hi - 1e-14))) continue;
            ++met;
            ASSERT_TRUE(overlaps) << i;
            ASSERT_TRUE(glm::all(glm::lessThanEqual(dvec3(part.lo), p + 1e-14)) &&
                        glm::all(glm::lessThanEqual(p - 1e-14, dvec3(part.hi))))
                << i;
        }
    }
    EXPECT_GT(met, 1000u);
    EXPECT_GT(apart, 100u);
    EXPECT_GT(hollow, 10u);
}

// Structures that cut space refer to the surface: what is inside costs nothing.
TEST(Spheres, AreReferredToByTheirSurface) {
    std::vector<Primitive> primitives = {Primitive::sphere(vec3(0), 1.0f)};
    for (const Triangle& t : test::sphere(40, 0.3, dvec3(0))) primitives.push_back(t);
    for (const char* name : {"kdtree", "octree"}) {
        const Structure with = structureType(name).build(primitives, {});
        EXPECT_EQ(structureType(name).findFault(with, primitives), std::nullopt);
        const Structure without = structureType(name).build(std::span(primitives).subspan(1), {});
        EXPECT_LT(with.statistics.references, without.statistics.references * 5 / 4) << name;
    }
}

TEST(ReferenceSphere, CrossesWhereExactArithmeticDoes) {
    Random random(6);
    for (int i = 0; i < 100'000; ++i) {
        const Primitive sphere =
            Primitive::sphere(random.inCube(-1, 1), static_cast<float>(std::pow(10.0, random.within(-6, 0))));
        const Ray ray = test::rayAtSphere(sphere, random);
        const Exact exact(ray, sphere);
        const reference::Ray wide{dvec3(ray.origin), dvec3(ray.direction)};
        const auto got = reference::crossSphere(wide, sphere.centre(), sphere.radius());
        const Quad rest = exact.b * exact.b - exact.a * exact.c;
        ASSERT_EQ(got.has_value(), rest >= 0) << test::describe(ray);
        if (!got) continue;
        const Quad root = rootOf(rest);
        const double near = static_cast<double>((exact.b - root) / exact.a),
                     far = static_cast<double>((exact.b + root) / exact.a);
        const double allowed = 0x1p-30 * std::max(std::abs(near), std::abs(far));
        ASSERT_NEAR(got->near, near, allowed);
        ASSERT_NEAR(got->far, far, allowed);
        // On the surface, to which half a step of the root's own rounding is 2^-26 of the radius at a tangent.
        ASSERT_LT(std::abs(exact.offset(got->near)), 1e-7 * sphere.radius());
    }
}

TEST(ReferenceSphere, NearestPointsAreNearest) {
    Random random(7);
    for (int i = 0; i < 300; ++i) {
        const vec3 centre = random.inCube(-1, 1);
        const auto radius = static_cast<float>(random.within(0.1, 1.0));
        const double tMin = random.within(-2, 2);
        const reference::Ray ray{dvec3(random.inCube(-2, 2)), random.direction(), tMin, tMin + random.within(0, 4)};
        const reference::Approach got = reference::approachSphere(ray, centre, radius);
        ASSERT_TRUE(got.t >= ray.tMin && got.t <= ray.tMax);
        EXPECT_NEAR(reference::distanceToSphere(ray.origin + got.t * ray.direction, centre, radius), got.distance, 1e-7);
        for (int j = 0; j <= 200; ++j) {
            const double t = glm::mix(ray.tMin, ray.tMax, j / 200.0);
            ASSERT_GE(reference::distanceToSphere(ray.origin + t * ray.direction, centre, radius), got.distance - 1e-7);
        }
    }
}

}  // namespace
}  // namespace raig

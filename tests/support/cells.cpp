#include "support/cells.hpp"

#include "base/random.hpp"
#include "support/sphere_soups.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace raig::test {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

class PlaneAimer {
public:
    PlaneAimer(const std::vector<Triangle>& triangles, const std::vector<AxisPlane>& planes, uint64_t seed)
        : triangles_(triangles), planes_(planes), random_(seed) {
        for (const Triangle& t : triangles)
            if (t.usable()) box_.grow(t.box());
        size_ = glm::length(dvec3(box_.extent()));
    }

    Ray ray(size_t family) {
        const vec3 target = corner();
        Ray ray{origin(), 0.0f, vec3(0.0f), inf};
        switch (family) {
            case 0:  // through a corner, or an edge, of cells
                ray.direction = target - ray.origin;
                break;
            case 1:  // in a plane: one component zero, of either sign
            case 2: {
                const AxisPlane& plane = anyPlane();
                ray.direction = vec3(random_.direction());
                ray.direction[plane.axis] = signedZero();
                if (family == 2) ray.direction[(plane.axis + 1) % 3] = signedZero();  // and along an axis
                ray.origin[plane.axis] = plane.at;
                break;
            }
            case 3: {  // from a plane, to anywhere
                const AxisPlane& plane = anyPlane();
                ray.origin = pointOnTriangle();
                ray.origin[plane.axis] = plane.at;
                ray.direction = vec3(random_.direction());
                break;
            }
            case 4: {  // an interval that begins or ends on a plane
                const AxisPlane& plane = anyPlane();
                ray.direction = vec3(random_.direction());
                const float t = (plane.at - ray.origin[plane.axis]) / ray.direction[plane.axis];
                if (!(std::abs(t) < 1e30f)) break;
                ray.direction *= t < 0.0f ? -1.0f : 1.0f;
                (random_.below(2) == 0 ? ray.tMin : ray.tMax) = std::abs(t);
                break;
            }
            case 5: {  // nearly in a plane
                const AxisPlane& plane = anyPlane();
                ray.direction = vec3(random_.direction());
                ray.direction[plane.axis] =
                    static_cast<float>(ray.direction[plane.axis] * std::pow(10.0, random_.within(-9, -3)));
                ray.origin = pointOnTriangle();
                ray.origin[plane.axis] = plane.at;
                ray.origin = vec3(dvec3(ray.origin) - dvec3(ray.direction) * size_ * random_.within(0, 2));
                break;
            }
            default: {  // from far away, at a corner or at a triangle
                const double far = std::pow(10.0, random_.within(1, 6));
                ray.origin = vec3(dvec3(box_.centre()) + random_.direction() * far * size_);
                ray.direction = vec3(dvec3(family == 6 ? target : pointOnTriangle()) - dvec3(ray.origin));
                break;
            }
        }
        return ray;
    }

private:
    const AxisPlane& anyPlane() { return planes_[random_.below(static_cast<uint32_t>(planes_.size()))]; }
    float signedZero() { return random_.below(2) == 0 ? 0.0f : -0.0f; }
    vec3 origin() { return vec3(dvec3(box_.centre()) + size_ * dvec3(random_.inCube(-1, 1))); }

    vec3 pointOnTriangle() {
        for (;;) {
            const Triangle& t = triangles_[random_.below(static_cast<uint32_t>(triangles_.size()))];
            if (!t.usable()) continue;
            if (t.isSphere()) return pointOnSphere(t, random_);
            const double r = std::sqrt(random_.unit()), s = random_.unit();
            return vec3((1 - r) * dvec3(t.a) + r * (1 - s) * dvec3(t.b) + r * s * dvec3(t.c));
        }
    }
    /// A point of a triangle moved onto one, two or three planes.
    vec3 corner() {
        vec3 result = pointOnTriangle();
        for (uint32_t i = 1 + random_.below(3); i > 0; --i) {
            const AxisPlane& plane = anyPlane();
            result[plane.axis] = plane.at;
        }
        return result;
    }

    const std::vector<Triangle>& triangles_;
    const std::vector<AxisPlane>& planes_;
    Random random_;
    Box box_;
    double size_ = 1.0;
};

}  // namespace

std::vector<Ray> raysAtPlanes(const std::vector<Triangle>& triangles, const std::vector<AxisPlane>& planes, uint64_t seed,
                              size_t count) {
    PlaneAimer aimer(triangles, planes, seed);
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i) rays.push_back(aimer.ray(i % 8));
    return rays;
}

std::vector<Soup> growingSoups() {
    Random random(1);
    const Triangle flat{vec3(-0.5f, -0.5f, 0.0f), vec3(0.5f, -0.25f, 0.125f), vec3(0.0f, 0.5f, 0.25f)};
    const Triangle diagonal{vec3(0), vec3(1, 1, 0.9f), vec3(0, 1, 1)};
    Soup fan{"sharing a vertex", {}}, slivers{"slivers sharing a vertex", {}}, diagonals{"diagonal slivers", {}};
    for (int i = 0; i < 1000; ++i) {
        const vec3 a = random.inCube(-1, 1), b = random.inCube(-1, 1);
        fan.triangles.push_back({vec3(0), a, b});
        slivers.triangles.push_back({vec3(0), a, a + 1e-3f * b});
        diagonals.triangles.push_back({a, b, b + random.inCube(-1e-4, 1e-4)});
    }
    return {{"identical", std::vector<Triangle>(1000, flat)},
            {"identical diagonal", std::vector<Triangle>(1000, diagonal)},
            fan,
            slivers,
            diagonals};
}

Soup nearlyFlatSoup() {
    Random random(2);
    Soup soup{"nearly flat", {}};
    const auto corner = [&](float x, float z) {
        return vec3(x, std::bit_cast<float>(std::bit_cast<uint32_t>(2e-4f) + random.below(6)), z);
    };
    for (int i = 0; i < 1000; ++i) {
        const auto x = static_cast<float>(random.within(0, 0.02)), z = static_cast<float>(random.within(0, 0.02));
        soup.triangles.push_back({corner(x, z), corner(x + 0.003f, z), corner(x, z + 0.003f)});
    }
    for (const Triangle& t : sphere(30, 0.01, dvec3(0.01, 2e-4, 0.01), 0.1)) soup.triangles.push_back(t);
    soup.triangles.push_back({vec3(-1), vec3(1, -1, -1), vec3(-1, -1, 1)});
    return soup;
}

}  // namespace raig::test

#include "support/grids.hpp"

#include "rays/tracer.hpp"
#include "structures/grid.hpp"
#include "structures/grid_shape.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace raig {
namespace {

/// The walk of the grid at so many levels as C++, to be stopped and taken up again at will.
namespace walks {
using namespace glm;
using namespace shared;
#define COUNT_NODE(did)
#define COUNT_TRIANGLE(did)
struct Arrays {
    static constexpr bool HAS_SPHERES = true;
    explicit Arrays(const Structure& structure) : header(structure.header), structure_(structure) {}
    uvec4 nodes_at(uint i) const { return structure_.nodes.at(i); }
    uvec4 triangles_at(uint i) const { return structure_.triangles.at(i); }
    const StructureHeader& header;
    const Structure& structure_;
};

template <uint WALK, bool ANY_HIT, bool SKIP_SEE_THROUGH>
struct Walk : Arrays {
    using Arrays::Arrays;
#include "intersect.glsl"
#include "structures/grid.glsl"
#include "trace.glsl"
#include "triangles.glsl"
};
#undef HAS_WALK

/// The same of nested grids.
template <bool ANY_HIT, bool SKIP_SEE_THROUGH>
struct Walk<2u, ANY_HIT, SKIP_SEE_THROUGH> : Arrays {
    static constexpr uint WALK = 2u;
    using Arrays::Arrays;
#include "intersect.glsl"
#include "structures/grid_nested.glsl"
#include "trace.glsl"
#include "triangles.glsl"
};
}  // namespace walks

template <uint32_t walkNumber>
std::vector<Hit> inPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t maxSteps) {
    walks::Walk<walkNumber, false, false> walk(structure);
    std::vector<Hit> hits(rays.size(), {0.0f, 0.0f, 0.0f, NO_HIT});
    for (size_t i = 0; i < rays.size(); ++i) {
        uvec4 at(0u);
        uint32_t pieces = 1;
        while (!walk.traceRay(rays[i], at, maxSteps, hits[i]))
            if (++pieces == 1'000'000) {
                ADD_FAILURE() << "does not end: " << test::describe(rays[i]);
                break;
            }
    }
    return hits;
}

template <uint32_t walkNumber>
void asFarAsMaybe(const Structure& structure, const std::vector<Ray>& rays) {
    walks::Walk<walkNumber, false, false> walk(structure);
    for (const Ray& ray : rays) {
        uvec4 at(0u);
        Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
        walk.traceRay(ray, at, static_cast<uint32_t>(walk.mostSteps()), hit);
    }
}

constexpr float inf = std::numeric_limits<float>::infinity();

}  // namespace

namespace test {

Structure gridOver(const std::vector<Triangle>& triangles, uint32_t levels, float density) {
    return grid::build(triangles, {.gridDensity = density, .levels = levels});
}

size_t expectAsBrute(const Structure& structure, const std::vector<Triangle>& triangles, const std::vector<Ray>& rays,
                     const std::string& what) {
    const Structure brute = structureType("brute").build(triangles, {});
    std::vector<Hit> want(rays.size()), got(rays.size()), any(rays.size());
    makeCpuTracer(brute)->trace(rays, want, Query::closest);
    makeCpuTracer(structure)->trace(rays, got, Query::closest);
    makeCpuTracer(structure)->trace(rays, any, Query::any);
    size_t hits = 0, wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        hits += want[i].primitive != NO_HIT;
        const bool same = std::memcmp(&want[i], &got[i], sizeof(Hit)) == 0 &&
                          (any[i].primitive == NO_HIT) == (want[i].primitive == NO_HIT);
        if (!same && wrong++ == 0)
            ADD_FAILURE() << what << " ray " << i << ' ' << test::describe(rays[i]) << " finds " << got[i].primitive
                          << " at " << got[i].t << " and should find " << want[i].primitive << " at " << want[i].t;
    }
    EXPECT_EQ(wrong, 0u) << what << ", of " << rays.size();
    return hits;
}

dvec3 placeOnCell(const Structure& structure, Random& random) {
    const grid::Shape shape = grid::shapeOf(structure);
    const uint32_t parts = structure.header.walk == 0 ? 1 : 4;
    dvec3 place;
    for (int axis = 0; axis < 3; ++axis) {
        const double number = random.below(shape.cells.count[axis] * parts + 1) / double(parts);
        place[axis] = shape.cells.origin[axis] + shape.cells.step[axis] * number;
    }
    for (uint32_t free = random.below(3); free > 0; --free) {
        const auto axis = static_cast<int>(random.below(3));
        place[axis] = shape.cells.origin[axis] + shape.cells.step[axis] * shape.cells.count[axis] * random.unit();
    }
    return place / double(structure.header.unit);
}

std::vector<Ray> raysAtCells(const Structure& structure, const std::vector<Triangle>& triangles, uint64_t seed,
                             size_t count) {
    Random random(seed);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const vec3 from = vec3(placeOnCell(structure, random)), to = vec3(placeOnCell(structure, random));
        const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
        Ray ray{from, 0.0f, to - from, inf};
        switch (rays.size() % 4) {
            case 0:  // through two places
                ray.origin = vec3(2.0 * dvec3(from) - dvec3(to));
                break;
            case 1:  // from one at a triangle
                ray.direction = t.a + 0.25f * (t.b - t.a) - from;
                break;
            case 2:  // within a face, or along an edge
                for (uint32_t zeros = 1 + random.below(2); zeros > 0; --zeros)
                    ray.direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 0.0f : -0.0f;
                break;
            default:  // along an axis, from a face or outside
                for (int axis = 0; axis < 3; ++axis) ray.direction[axis] = random.below(2) == 0 ? 0.0f : -0.0f;
                ray.direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 1.0f : -1.0f;
                if (random.below(2) == 0) ray.origin -= ray.direction * glm::length(to - from);
                break;
        }
        rays.push_back(ray);
    }
    return rays;
}

std::vector<Hit> walkInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t maxSteps) {
    switch (structure.header.walk) {
        case 0:
            return inPieces<0>(structure, rays, maxSteps);
        case 1:
            return inPieces<1>(structure, rays, maxSteps);
        default:
            return inPieces<grid::nestedWalk>(structure, rays, maxSteps);
    }
}

void walkAsFarAsMaybe(const Structure& structure, const std::vector<Ray>& rays) {
    switch (structure.header.walk) {
        case 0:
            return asFarAsMaybe<0>(structure, rays);
        case 1:
            return asFarAsMaybe<1>(structure, rays);
        default:
            return asFarAsMaybe<grid::nestedWalk>(structure, rays);
    }
}

std::vector<Triangle> stadium(double size, const dvec3& centre) {
    Random random(51);
    std::vector<Triangle> triangles = test::sphere(55, size, centre, 0.1);
    for (const float y : {-0.3f, 2.0f}) {
        triangles.push_back({vec3(-1000, y, -1000), vec3(1000, y, -1000), vec3(1000, y, 1000)});
        triangles.push_back({vec3(-1000, y, -1000), vec3(1000, y, 1000), vec3(-1000, y, 1000)});
    }
    for (int i = 0; i < 600; ++i) {
        const double extent = size * std::exp2(random.within(-8.0, 8.0));
        const dvec3 at = centre + 2.0 * size * dvec3(random.inCube(-1, 1)), a = random.direction(), b = random.direction();
        triangles.push_back({vec3(at), vec3(at + extent * a), vec3(at + extent * (i % 2 == 0 ? 1.001 * a + 1e-6 * b : b))});
    }
    return triangles;
}

}  // namespace test
}  // namespace raig

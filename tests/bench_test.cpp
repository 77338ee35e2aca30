// The standard sets of rays, against an independent computation of their definition, and the statistics of `raig bench`.
#include "measure/bench.hpp"
#include "measure/ray_sets.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <regex>

namespace raig {
namespace {

/// A square 2 x 2 in the plane y = 0, and one of 1 x 1 at y = 1 over its middle.
Geometry twoSquares() {
    Geometry g;
    for (const auto& [half, y] : {std::pair(1.0f, 0.0f), std::pair(0.5f, 1.0f)}) {
        const auto first = static_cast<uint32_t>(g.positions.size());
        for (const auto& [x, z] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
            g.positions.push_back(vec3(half * float(x), y, half * float(z)));
        g.triangles.push_back({first, first + 1, first + 2});
        g.triangles.push_back({first, first + 2, first + 3});
    }
    for (const vec3& p : g.positions) g.bounds.grow(p);
    return g;
}

RaySets setsOf(const Geometry& g, uint32_t side) {
    std::vector<Triangle> triangles;
    for (const uvec3& t : g.triangles) triangles.push_back({g.positions[t.x], g.positions[t.y], g.positions[t.z]});
    const Structure structure = structureType("brute").build(triangles, {});
    return makeRaySets(g, g.bounds, measuringCamera(g, g.bounds), side, *makeCpuTracer(structure));
}

/// Where a ray meets the squares: the height of the plane, or nothing.
std::optional<double> heightHit(const dvec3& o, const dvec3& d) {
    for (const auto& [half, y] : {std::pair(0.5, 1.0), std::pair(1.0, 0.0)}) {
        const dvec3 p = o + d * ((y - o.y) / d.y);
        if (std::abs(p.x) <= half && std::abs(p.z) <= half) return y;
    }
    return std::nullopt;
}

TEST(RaySets, SeeEveryVertexInTheMiddleOfThePicture) {
    const Geometry g = twoSquares();
    const MeasuringCamera camera = measuringCamera(g, g.bounds);
    double most = 0.0;
    for (const vec3& p : g.positions) {
        const dvec3 v = dvec3(p) - camera.eye;
        const double depth = glm::dot(v, camera.forward) * std::tan(22.5 * std::acos(-1.0) / 180.0);
        most = std::max({most, std::abs(glm::dot(v, camera.right)) / depth, std::abs(glm::dot(v, camera.up)) / depth});
    }
    EXPECT_NEAR(most, 0.95, 1e-12);
}

// Pixel by pixel, from the definition: tiles of 8 x 8 row by row, a Morton curve in each.
TEST(RaySets, HoldTheRaysOfTheirDefinition) {
    constexpr uint32_t side = 16;
    const Geometry g = twoSquares();
    const RaySets sets = setsOf(g, side);
    ASSERT_EQ(sets.primary.size(), side * side);
    const double l = std::sqrt(0.25 + 0.1225 + 1.0);
    const dvec3 back(0.5 / l, 0.35 / l, 1.0 / l), f = -back;
    const double across = std::sqrt(f.x * f.x + f.z * f.z);
    const dvec3 r(-f.z / across, 0.0, f.x / across), u(r.y * f.z - r.z * f.y, r.z * f.x - r.x * f.z, r.x * f.y - r.y * f.x);
    const dvec3 eye = measuringCamera(g, g.bounds).eye, centre(0.0, 0.5, 0.0);
    const double tangent = std::sqrt(2.0) - 1.0;  // of 22.5 degrees
    const dvec3 light = centre + 3.0 * 1.5 * dvec3(-0.6, 1.0, 0.8) / std::sqrt(2.0);
    size_t k = 0, second = 0, shadow = 0;
    for (uint32_t ty = 0; ty < side; ty += 8)
        for (uint32_t tx = 0; tx < side; tx += 8)
            for (uint32_t m = 0; m < 64; ++m, ++k) {
                const uint32_t x = tx + (m & 1) + (m >> 2 & 1) * 2 + (m >> 4 & 1) * 4;
                const uint32_t y = ty + (m >> 1 & 1) + (m >> 3 & 1) * 2 + (m >> 5 & 1) * 4;
                dvec3 d = f + tangent * ((2.0 * x + 1.0) / side - 1.0) * r + tangent * (1.0 - (2.0 * y + 1.0) / side) * u;
                d /= std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_FLOAT_EQ(sets.primary[k].origin[axis], float(eye[axis]));
                    EXPECT_NEAR(sets.primary[k].direction[axis], d[axis], 1e-7) << k;
                }
                const std::optional<double> height = heightHit(eye, d);
                if (!height) continue;
                ASSERT_LT(second, sets.specular.size());
                const double t = (*height - eye.y) / d.y;
                const dvec3 start = eye + t * d + dvec3(0.0, 2e-5 * t, 0.0);
                EXPECT_NEAR(sets.specular[second].origin.y, start.y, 1e-6);
                EXPECT_NEAR(sets.specular[second].direction.y, -d.y, 1e-6);
                EXPECT_NEAR(sets.specular[second].direction.x, d.x, 1e-6);
                EXPECT_GE(sets.diffuse[second].direction.y, 0.0f);
                EXPECT_NEAR(glm::length(sets.diffuse[second].direction), 1.0f, 1e-6f);
                const dvec3 toLight = light - start;  // above both squares
                EXPECT_NEAR(sets.shadow[shadow].tMax, 0.9999 * glm::length(toLight), 1e-5);
                EXPECT_NEAR(sets.shadow[shadow].direction.x, toLight.x / glm::length(toLight), 1e-6);
                ++second;
                ++shadow;
            }
    EXPECT_EQ(second, sets.diffuse.size());
    EXPECT_EQ(second, sets.specular.size());
    EXPECT_EQ(shadow, sets.shadow.size());
    EXPECT_GT(second, side * side / 5);
}

// Of a cosine-weighted direction, the mean of the cosine is 2/3 and its variance 1/18.
TEST(RaySets, LeaveDiffuseSurfacesByTheCosine) {
    const RaySets sets = setsOf(twoSquares(), 128);
    double sum = 0.0;
    for (const Ray& ray : sets.diffuse) sum += ray.direction.y;
    const auto count = static_cast<double>(sets.diffuse.size());
    ASSERT_GT(count, 3000.0);
    EXPECT_NEAR(sum / count, 2.0 / 3.0, 4.0 * std::sqrt(1.0 / 18.0 / count));
}

TEST(Quartiles, LieBetweenValues) {
    const Quartiles q = quartilesOf({5.0, 1.0, 4.0, 2.0, 3.0});
    EXPECT_EQ(q.median, 3.0);
    EXPECT_EQ(q.q1, 2.0);
    EXPECT_EQ(q.q3, 4.0);
    EXPECT_EQ(quartilesOf({2.0, 1.0}).median, 1.5);
    EXPECT_EQ(quartilesOf({7.0}).q3, 7.0);
}

TEST(BenchCommand, TellsSpeedsOfAllSetsAsJson) {
    const ProgramResult result = runProgram(RAIG_PROGRAM, {"bench", RAIG_SOURCE_DIR "/assets/cornell_box.gltf", "--side",
                                                           "64", "--repeat", "2", "--device", "cpu", "--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const nlohmann::json json = nlohmann::json::parse(result.output);
    ASSERT_EQ(json["results"].size(), 4u) << json;
    EXPECT_EQ(json.at("device"), "cpu");
    EXPECT_TRUE(json.at("driver").is_null());
    EXPECT_EQ(json.at("arithmetic").at("ieee"), true);
    EXPECT_TRUE(std::regex_match(json.at("commit").get<std::string>(), std::regex("unknown|[0-9a-f]{40,64}(-dirty)?")));
    for (const auto& one : json["results"]) {
        EXPECT_GT(one["mrays_per_s"]["median"], 0.0);
        EXPECT_GT(one["counters"]["node_fetches"], 0);
        EXPECT_EQ(one["counters"]["box_tests"], one["counters"]["node_fetches"]) << "a box a node";
        if (one["rays"] == "primary") {  // others may pass all leaves by
            EXPECT_GT(one["counters"]["primitive_tests"], 0);
        }
        EXPECT_EQ(one["counters"]["link_reads"], 0);
        if (!one["hits_embree"].is_null()) {
            EXPECT_GE(one["hits_embree"], 0.9 * one["hits"].get<double>());
        }
    }
    ASSERT_EQ(json["builds"].size(), 1u);
    EXPECT_GT(json["builds"][0]["bytes"], 0);
}

}  // namespace
}  // namespace raig

// What is told of a scene and of the structures in it, and the choice among them.
#include "measure/trials.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace raig {
namespace {

namespace fs = std::filesystem;

/// `triangles` as a scene of one mesh.
Scene sceneOf(const std::vector<Triangle>& triangles) {
    Scene scene;
    Mesh mesh;
    for (const Primitive& t : triangles) {
        mesh.materials.push_back(0);
        if (t.isSphere()) {
            mesh.spheres.push_back({t.centre(), t.radius()});
            continue;
        }
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {t.a, t.b, t.c});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    scene.materials.emplace_back();
    scene.meshes.push_back(mesh);
    scene.instances.push_back({});
    completeScene(scene);
    return scene;
}

/// A small mesh in a wide hall.
std::vector<Triangle> teapotInStadium() {
    std::vector<Triangle> triangles = test::sphere(30, 0.01, dvec3(3, 0, 1), 0.1);
    for (const Triangle& hall : test::sphere(12, 100.0, dvec3(0))) triangles.push_back(hall);
    return triangles;
}

std::vector<Trial> trialsOf(const std::vector<Triangle>& triangles) {
    const Scene scene = sceneOf(triangles);
    const Geometry geometry = flatten(scene);
    return tryStructures(scene, geometry, primitivesOf(geometry), {});
}

TEST(SceneNumbers, AreThoseOfTheTriangles) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const SceneNumbers numbers = measureScene(std::vector<Triangle>{{vec3(0), vec3(1, 0, 0), vec3(0, 2, 0)},
                                                                    {vec3(0, 0, 1), vec3(4, 0, 1), vec3(0, 1, 1)},
                                                                    {vec3(0, 0, 9), vec3(0, 0, 9), vec3(0, 1, 9)},
                                                                    {vec3(nan), vec3(1, 0, 0), vec3(0, 2, 0)},
                                                                    {vec3(0), vec3(-8, 0, 0), vec3(0, 2, 3)}});
    EXPECT_EQ(numbers.triangles, 5u);
    EXPECT_EQ(numbers.usable, 3u);
    EXPECT_EQ(numbers.bounds.lo, vec3(-8, 0, 0));
    EXPECT_EQ(numbers.bounds.hi, vec3(4, 2, 3));
    EXPECT_EQ(numbers.largestExtent, 8.0f);
    EXPECT_EQ(numbers.medianExtent, 4.0f);
    EXPECT_EQ(numbers.sizesRatio(), 2.0);
    EXPECT_EQ(measureScene({}).sizesRatio(), 1.0);
    EXPECT_EQ(measureScene({}).usable, 0u);
}

TEST(SceneNumbers, TellATeapotInAStadiumAndNothingElse) {
    EXPECT_TRUE(measureScene(teapotInStadium()).isUneven());
    for (const uint32_t rings : {2, 10, 40, 150}) {
        EXPECT_FALSE(measureScene(test::sphere(rings, 1.0, dvec3(0))).isUneven()) << rings;
        EXPECT_FALSE(measureScene(test::sphere(rings, 1.0, dvec3(500, 0, 0), 0.1)).isUneven()) << rings;
    }
    // Triangles in one place crowd in whatever grid; in a plane they lie in a grid that is as flat.
    std::vector<Triangle> wall;
    for (int x = 0; x < 40; ++x)
        for (int y = 0; y < 40; ++y) wall.push_back({vec3(x, y, 1), vec3(x + 1, y, 1), vec3(x, y + 1, 1)});
    const SceneNumbers flat = measureScene(wall);
    EXPECT_FALSE(flat.isUneven());
    EXPECT_LE(flat.crowding, 4.0);
    // Two crowds in opposite corners: all but two of the cells are empty.
    std::vector<Triangle> crowds(50, wall.front());
    crowds.resize(100, wall.back());
    EXPECT_EQ(measureScene(crowds).crowding, 50.0);
}

TEST(SceneNumbers, NameWhatTheSceneUses) {
    const fs::path assets = fs::path(RAIG_SOURCE_DIR) / "assets";
    const auto features = [&](const char* file) {
        const Scene scene = importScene(assets / file);
        return featuresOf(scene, flatten(scene));
    };
    const auto has = [](const std::vector<std::string>& all, const char* one) {
        return std::find(all.begin(), all.end(), one) != all.end();
    };
    const std::vector<std::string> box = features("cornell_box.gltf"), spheres = features("cornell_spheres.gltf");
    EXPECT_TRUE(has(box, "emission"));
    EXPECT_FALSE(has(box, "mirrors"));
    EXPECT_FALSE(has(box, "transmission"));
    for (const char* feature : {"emission", "mirrors", "transmission", "refraction"})
        EXPECT_TRUE(has(spheres, feature)) << feature;
    // A material that no triangle has is not used.
    Scene scene = sceneOf(test::sphere(3, 1.0, dvec3(0)));
    scene.materials.emplace_back().transmission = 1.0f;
    EXPECT_FALSE(has(featuresOf(scene, flatten(scene)), "transmission"));
    EXPECT_EQ(countUsedMaterials(scene, flatten(scene)), 1u);
}

TEST(Trials, CoverEveryStructureAndCountWhatRaysMeet) {
    const std::vector<Triangle> triangles = test::sphere(30, 1.0, dvec3(0), 0.1);
    const std::vector<Trial> trials = trialsOf(triangles);
    ASSERT_EQ(trials.size(), structureTypes().size());
    for (size_t i = 0; i < trials.size(); ++i) {
        const Trial& trial = trials[i];
        EXPECT_EQ(trial.name, structureTypes()[i].name);
        EXPECT_EQ(trial.trouble, "") << trial.name;
        EXPECT_GT(trial.structure.statistics.bytes, 0u) << trial.name;
        EXPECT_TRUE(trial.structure.nodes.empty() && trial.structure.triangles.empty()) << "not to be kept";
        EXPECT_GT(trial.cost.triangleTests, 0.5) << trial.name << ": the rays meet nothing";
        EXPECT_LE(trial.cost.triangleTests, double(triangles.size())) << trial.name;
    }
    // Brute force tests all triangles with every ray and looks at no node.
    EXPECT_EQ(trials[0].name, "brute");
    EXPECT_EQ(trials[0].cost.triangleTests, double(triangles.size()));
    EXPECT_EQ(trials[0].cost.nodeVisits, 0.0);
    EXPECT_EQ(trials[0].cost.total(), 2.0 * double(triangles.size()));
}

TEST(Trials, AreTheSameEveryTime) {
    const std::vector<Trial> a = trialsOf(teapotInStadium()), b = trialsOf(teapotInStadium());
    for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].cost.total(), b[i].cost.total()) << a[i].name;
}

TEST(Trials, LeaveBruteForceOutWhereItTakesTooLong) {
    const std::vector<Trial> trials = trialsOf(test::sphere(50, 1.0, dvec3(0)));
    EXPECT_NE(trials[0].trouble.find("4096"), std::string::npos) << trials[0].trouble;
}

// A rule that only ever says "the cheapest", or only "bvh", would not need one: it stays near the cheapest all the same.
TEST(Choice, CostsAtMostOneAndAHalfTimesTheCheapest) {
    std::vector<test::Soup> soups = test::soups();
    soups.push_back({"teapot in a stadium", teapotInStadium()});
    for (const char* file : {"cornell_box.gltf", "cornell_spheres.gltf"})
        soups.push_back({file, primitivesOf(flatten(importScene(fs::path(RAIG_SOURCE_DIR) / "assets" / file)))});
    const fs::path scenes = fs::path(RAIG_SOURCE_DIR) / "../shared/scenes";
    if (test::isLong())
        for (const char* file : {"meshes/bunny.ply", "stadium/house_and_bunny.glb", "rooms/fzk_haus.glb"})
            if (fs::exists(scenes / file)) soups.push_back({file, primitivesOf(flatten(importScene(scenes / file)))});
    for (const test::Soup& soup : soups) {
        const std::vector<Trial> trials = trialsOf(soup.triangles);
        const Choice choice = chooseStructure(soup.triangles.size(), trials);
        double least = std::numeric_limits<double>::infinity(), chosen = -1.0;
        for (const Trial& trial : trials) {
            if (trial.trouble.empty()) least = std::min(least, trial.cost.total());
            if (trial.name == choice.structure) chosen = trial.cost.total();
        }
        EXPECT_GE(chosen, 0.0) << soup.name << ": " << choice.structure << " was not tried";
        EXPECT_LE(chosen, 1.5 * least) << soup.name << ": " << choice.structure << ", " << choice.why;
        EXPECT_EQ(choice.why.find('\n'), std::string::npos);
    }
}

Trial costing(const char* name, double tests, const char* trouble = "") {
    return {.name = name, .trouble = trouble, .structure = {}, .cost = {0.0, tests, 1.0}};
}

TEST(Choice, PrefersBvhUnlessAnotherIsClearlyCheaper) {
    const Trial brute = costing("brute", 50.0), bvh = costing("bvh", 10.0);
    EXPECT_EQ(chooseStructure(100, std::vector{brute, bvh, costing("grid", 9.0)}).structure, "bvh");
    EXPECT_EQ(chooseStructure(100, std::vector{brute, bvh, costing("grid", 7.0)}).structure, "grid");
    EXPECT_EQ(chooseStructure(100, std::vector{brute, bvh, costing("grid", 7.0, "no memory")}).structure, "bvh");
    EXPECT_EQ(chooseStructure(100, std::vector{costing("brute", 1.0), bvh}).structure, "brute");
    EXPECT_EQ(chooseStructure(mostForTrials + 1, {}).structure, "bvh");
    const Choice choice = chooseStructure(100, std::vector{brute, bvh, costing("grid", 7.0)});
    EXPECT_EQ(choice.why, "predicted cost of a ray 14.0, the least, that of bvh is 20.0");
}

}  // namespace
}  // namespace raig

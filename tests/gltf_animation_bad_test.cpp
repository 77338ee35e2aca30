// What is wrong with an animation, a skin or a morph target is said in one line that points at it; nothing crashes or hangs.
#include "base/error.hpp"
#include "scene/validate.hpp"
#include "support/moving_assets.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <random>

namespace raig {
namespace {

using nlohmann::json;
using test::bendingBar;
using test::GltfAsset;
using test::morphedTriangle;

const Moment halfWay{0.5, ""};

/// What is said of the file; empty if a sound scene is made of it.
std::string refusalOf(const std::filesystem::path& path, const Moment& moment) {
    try {
        const Scene scene = importGltf(path, moment);
        EXPECT_EQ(findFault(scene), std::nullopt);
        return "";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_TRUE(error.exitCode == ExitCode::badInput || error.exitCode == ExitCode::usage) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        EXPECT_FALSE(text.empty());
        return text;
    }
}

std::string refusalOf(const GltfAsset& asset, const Moment& moment) {
    const test::TemporaryFolder folder;
    writeFileAtomically(folder.path / "asset.glb", asset.glb());
    return refusalOf(folder.path / "asset.glb", moment);
}

void expectRefused(const GltfAsset& asset, const Moment& moment, const std::string& part) {
    const std::string text = refusalOf(asset, moment);
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' does not name " << part;
}

struct Change {
    const char* pointer;
    json value;
    const char* part;
};

constexpr const char* sampler = "#/animations/0/samplers/0";

TEST(BadAnimation, WhatIsBrokenIsNamed) {
    const std::string in = std::string(sampler) + "/input", out = std::string(sampler) + "/output";
    const Change cases[] = {
        {"/animations/0/channels/0/sampler", 1, "#/animations/0/channels/0/sampler: names sampler 1, but there are 1"},
        {"/animations/0/channels/0/sampler", -1, "#/animations/0/channels/0/sampler: must be a non-negative integer"},
        {"/animations/0/channels/0/target", 3, "#/animations/0/channels/0/target: must be an object"},
        {"/animations/0/channels/0/target/node", 3, "#/animations/0/channels/0/target/node: names node 3, but there are 3"},
        {"/animations/0/channels/0/target/path", 3, "#/animations/0/channels/0/target/path: must be a string"},
        {"/animations/0/channels/0/target/path", "scale", "/output: accessor 7 has 4 components"},
        {"/animations/0/channels/0/target/path", "weights", "/target: node 1 has no morph targets"},
        {"/animations/0/samplers/0/input", 99, "/input: names accessor 99, but there are 8"},
        {"/animations/0/samplers/0/input", 1, "/input: accessor 1 has 3 components"},
        {"/animations/0/samplers/0/output", 99, "/output: names accessor 99, but there are 8"},
        {"/animations/0/samplers/0/output", 3, "/output: has 6 elements for 2 keyframes, which need 2"},
        {"/animations/0/samplers/0/interpolation", "CUBICSPLINE", "/output: has 2 elements for 2 keyframes, which need 6"},
        {"/animations/0/samplers/0/interpolation", "BEZIER\n", "/interpolation: is 'BEZIER'"},
        {"/animations/0/samplers/0/interpolation", 1, "/interpolation: must be a string"},
        {"/accessors/6/componentType", 5125, "/input: accessor 6 has component type 5125"},
        {"/accessors/7/componentType", 5125, "/output: accessor 7 has component type 5125"},
        {"/accessors/7/componentType", 5122, "/output: accessor 7 holds integers that are not normalized"},
        {"/accessors/6/count", 1, "/output: has 2 elements for 1 keyframes, which need 1"},
        {"/accessors/6/count", 0, "/input: has no keyframes"},
        {"/nodes/1/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "node 1 has a matrix"},
    };
    ASSERT_EQ(refusalOf(bendingBar(), halfWay), "");
    for (const auto& [pointer, value, part] : cases) {
        SCOPED_TRACE(std::string(pointer) + " = " + value.dump());
        GltfAsset asset = bendingBar();
        if (std::string(pointer) == "/nodes/1/matrix") asset.json["nodes"][1].erase("translation");
        asset.json[json::json_pointer(pointer)] = value;
        expectRefused(asset, halfWay, part);
    }
}

TEST(BadAnimation, WhatIsMissingIsNamed) {
    const std::pair<const char*, const char*> cases[] = {
        {"/animations/0/channels/0/sampler", "#/animations/0/channels/0: names no sampler"},
        {"/animations/0/channels/0/target", "#/animations/0/channels/0: has no target"},
        {"/animations/0/channels/0/target/path", "#/animations/0/channels/0/target: has no path"},
        {"/animations/0/samplers/0/input", "#/animations/0/samplers/0: names no input"},
        {"/animations/0/samplers/0/output", "#/animations/0/samplers/0: names no output"},
        {"/animations/0/samplers", "#/animations/0/channels/0/sampler: names sampler 0, but there are 0"},
        {"/skins/0/joints", "#/skins/0: has no joints"},
        {"/meshes/0/primitives/0/attributes/JOINTS_0", "#/meshes/0/primitives/0/attributes: has no JOINTS_0"},
        {"/meshes/0/primitives/0/attributes/WEIGHTS_0", "/attributes: has JOINTS_0, but no WEIGHTS_0"},
    };
    for (const auto& [pointer, part] : cases) {
        GltfAsset asset = bendingBar();
        const json::json_pointer at(pointer);
        asset.json[at.parent_pointer()].erase(at.back());
        expectRefused(asset, halfWay, part);
    }
}

TEST(BadAnimation, AnAnimationThatIsNotPlayedMayBeAnything) {
    GltfAsset asset = bendingBar();
    asset.json["animations"][0]["samplers"][0]["input"] = 99;
    EXPECT_EQ(refusalOf(asset, {}), "");
}

TEST(BadAnimation, TimesAndValuesAreNumbersInOrder) {
    const float infinity = std::numeric_limits<float>::infinity(), none = std::numeric_limits<float>::quiet_NaN();
    const auto withTimes = [](const std::vector<float>& times) {
        GltfAsset asset = bendingBar();
        asset.json["animations"][0]["samplers"][0]["input"] = asset.floats(times, "SCALAR");
        return asset;
    };
    expectRefused(withTimes({0, none}), halfWay, "/input: element 1 is not finite");
    expectRefused(withTimes({0, infinity}), halfWay, "/input: element 1 is not finite");
    expectRefused(withTimes({1, 0.5f}), halfWay, "/input: keyframe 1 at 0.5 s does not come after the one before, at 1 s");
    expectRefused(withTimes({1, 1}), halfWay, "/input: keyframe 1 at 1 s");
    expectRefused(withTimes({-1, 1}), halfWay, "/input: keyframe 0 is at -1 s");
    const auto withValues = [](const std::vector<float>& values) {
        GltfAsset asset = bendingBar();
        asset.json["animations"][0]["samplers"][0]["output"] = asset.floats(values, "VEC4");
        return asset;
    };
    expectRefused(withValues({0, 0, 0, 1, 0, none, 0, 1}), halfWay, "/output: element 1 is not finite");
    expectRefused(withValues({0, 0, 0, 1, 0, 0, 0, 0}), halfWay, "/output: the rotation at 0.5 s is zero");
    GltfAsset spline;
    const int node = spline.node({{"mesh", spline.triangle()}});
    test::animate(spline, 0, node, "translation", {1}, {0, 0, 0, 1, 1, 1, 0, 0, 0}, "VEC3", "CUBICSPLINE");
    expectRefused(spline, halfWay, "#/animations/0/samplers/0: is a spline of one keyframe");
    GltfAsset twice = bendingBar();
    json& channels = twice.json["animations"][0]["channels"];
    channels.push_back(channels[0]);
    expectRefused(twice, halfWay, "#/animations/0/channels/1/target: node 1's rotation has another channel already");
    GltfAsset huge;
    const int far = huge.node({{"mesh", huge.triangle()}});
    test::animate(huge, 0, far, "scale", {0, 1}, {1e30f, 1, 1, 3e38f, 1, 1}, "VEC3");
    EXPECT_EQ(refusalOf(huge, halfWay), "") << "finite, and so allowed: its triangles are dropped later";
}

TEST(BadSkin, WhatIsBrokenIsNamed) {
    const Change cases[] = {
        {"/skins/0/joints", json::array(), "#/skins/0: has no joints"},
        {"/skins/0/joints", 1, "#/skins/0/joints: must be an array"},
        {"/skins/0/joints/1", 3, "#/skins/0/joints/1: names node 3, but there are 3"},
        {"/skins/0/joints/1", "x", "#/skins/0/joints/1: must be a non-negative integer"},
        {"/skins/0/skeleton", 3, "#/skins/0/skeleton: names node 3"},
        {"/skins/0/inverseBindMatrices", 99, "#/skins/0/inverseBindMatrices: names accessor 99"},
        {"/skins/0/inverseBindMatrices", 3, "#/skins/0/inverseBindMatrices: accessor 3 does not hold 4 x 4 matrices"},
        {"/skins/0/joints", {0, 1, 2}, "#/skins/0/inverseBindMatrices: has 2 matrices for 3 joints"},
        {"/skins/0/joints", {0}, "/attributes/JOINTS_0: element 2 names joint 1, but the skin has 1"},
        {"/nodes/2/skin", 1, "#/nodes/2/skin: names skin 1, but there are 1"},
        {"/accessors/2/componentType", 5120, "/attributes/JOINTS_0: accessor 2 has component type 5120"},
        {"/accessors/3/componentType", 5123, "/attributes/WEIGHTS_0: accessor 3 holds integers that are not normalized"},
        {"/accessors/2/count", 5, "/attributes/JOINTS_0: has 5 elements, but there are 6"},
        {"/accessors/5/componentType", 5125, "does not hold 4 x 4 matrices of floats"},
    };
    for (const auto& [pointer, value, part] : cases) {
        SCOPED_TRACE(std::string(pointer) + " = " + value.dump());
        GltfAsset asset = bendingBar();
        asset.json[json::json_pointer(pointer)] = value;
        expectRefused(asset, {}, part);
    }
    const float none = std::numeric_limits<float>::quiet_NaN();
    const auto withWeights = [](float weight) {
        GltfAsset asset = bendingBar();
        std::vector<float> weights(24, 0.25f);
        weights[9] = weight;
        asset.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = asset.floats(weights, "VEC4");
        return asset;
    };
    expectRefused(withWeights(-0.5f), {}, "/attributes/WEIGHTS_0: element 2 holds -0.5");
    expectRefused(withWeights(none), {}, "/attributes/WEIGHTS_0: element 2 holds nan");
    const auto withMatrix = [](int k, float value) {
        GltfAsset asset = bendingBar();
        std::vector<float> numbers(32, 0.0f);
        for (const int i : {0, 5, 10, 15, 16, 21, 26, 31}) numbers[i] = 1.0f;
        numbers[k] = value;
        asset.json["skins"][0]["inverseBindMatrices"] = asset.floats(numbers, "MAT4");
        return asset;
    };
    expectRefused(withMatrix(3, 1.0f), {}, "#/skins/0/inverseBindMatrices: its last row is not 0 0 0 1");
    expectRefused(withMatrix(16, none), {}, "#/skins/0/inverseBindMatrices: matrix 1 is not finite");
    GltfAsset shape = bendingBar();
    shape.json["extensionsUsed"] = {"KHR_implicit_shapes"};
    shape.json["extensions"] = {{"KHR_implicit_shapes", {{"shapes", {{{"type", "sphere"}, {"sphere", {{"radius", 1}}}}}}}}};
    shape.json["meshes"][0]["primitives"].push_back({{"extensions", {{"KHR_implicit_shapes", {{"shape", 0}}}}}});
    expectRefused(shape, {}, "#/meshes/0/primitives/1: is a shape in a mesh that a node shows with a skin");
}

TEST(BadMorph, WhatIsBrokenIsNamed) {
    const Change cases[] = {
        {"/meshes/0/primitives/0/targets", 1, "#/meshes/0/primitives/0/targets: must be an array"},
        {"/meshes/0/primitives/0/targets/0", 1, "#/meshes/0/primitives/0/targets/0: must be an object"},
        {"/meshes/0/primitives/0/targets/0/POSITION", "x", "/targets/0/POSITION: must be a non-negative integer"},
        {"/meshes/0/primitives/0/targets/0/POSITION", 99, "/targets/0/POSITION: names accessor 99"},
        {"/meshes/0/primitives/0/targets/0/NORMAL", 6, "/targets/0/NORMAL: has 4 elements, but there are 3 positions"},
        {"/meshes/0/weights", {0.5}, "#/meshes/0/weights: has 1 weights for 2 morph targets"},
        {"/meshes/0/weights", {"x", 1}, "#/meshes/0/weights/0: must be a number"},
        {"/nodes/0/weights", {1, 2, 3}, "#/nodes/0/weights: has 3 weights for 2 morph targets"},
        {"/accessors/2/componentType", 5122, "/targets/0/POSITION: accessor 2 has component type 5122"},
        {"/accessors/6/count", 3, "/output: has 3 elements for 2 keyframes, which need 4"},
    };
    ASSERT_EQ(refusalOf(morphedTriangle(), halfWay), "");
    for (const auto& [pointer, value, part] : cases) {
        SCOPED_TRACE(std::string(pointer) + " = " + value.dump());
        GltfAsset asset = morphedTriangle();
        asset.json[json::json_pointer(pointer)] = value;
        expectRefused(asset, halfWay, part);
    }
    GltfAsset uneven = morphedTriangle();
    json& primitives = uneven.json["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[1]["targets"].erase(1);
    expectRefused(uneven, {}, "#/meshes/0/primitives/1/targets: has 1 morph targets, but the mesh's first primitive 2");
}

// A file of some kilobytes that asks for more than any machine has.
TEST(BadMorph, WhatTargetsWouldReadIsBounded) {
    GltfAsset asset;
    asset.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", 1 << 20}}};
    json targets = json::array(), weights = json::array();
    for (int i = 0; i < 200; ++i) {
        targets.push_back({{"POSITION", 0}});
        weights.push_back(1);
    }
    asset.node({{"mesh", asset.mesh({{"attributes", {{"POSITION", 0}}}, {"targets", targets}})}, {"weights", weights}});
    const test::TemporaryFolder folder;
    writeFileAtomically(folder.path / "asset.glb", asset.glb());
    try {
        importGltf(folder.path / "asset.glb");
        FAIL() << "it was read";
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::limit) << error.what();
    }
}

TEST(BadAnimation, AnyValueInTheJsonMayBeAnything) {
    const json values = {-1, 0, 7, 4294967297u, 1e18, "x", json::array(), json::object()};
    for (const auto& make : {bendingBar, morphedTriangle}) {
        const json flat = make().json.flatten();
        int refused = 0, rounds = 0;
        for (const auto& [pointer, value] : flat.items())
            for (const json& other : values) {
                GltfAsset asset = make();
                asset.json[json::json_pointer(pointer)] = other;
                SCOPED_TRACE(pointer + " = " + other.dump());
                refused += !refusalOf(asset, halfWay).empty();
                ++rounds;
            }
        EXPECT_GT(refused, rounds / 4);
        EXPECT_LT(refused, rounds);
    }
}

TEST(BadAnimation, RandomByteChangesAreRefusedOrLoadSoundly) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path / "changed.glb";
    std::mt19937 random(20240608);
    int refused = 0;
    constexpr int rounds = 600;
    for (int round = 0; round < rounds; ++round) {
        std::vector<std::byte> changed = (round % 2 ? bendingBar() : morphedTriangle()).glb();
        for (uint32_t change = 0; change <= round % 4u; ++change)
            changed[random() % changed.size()] = std::byte(random() & 0xff);
        writeFileAtomically(path, changed);
        SCOPED_TRACE(round);
        refused += !refusalOf(path, halfWay).empty();
    }
    EXPECT_GT(refused, rounds / 4);
    EXPECT_LT(refused, rounds);
}

}  // namespace
}  // namespace raig

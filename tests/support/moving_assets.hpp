/// glTF assets that move, of which it is known where everything is.
#pragma once

#include "support/gltf_asset.hpp"

namespace raig::test {

/// Adds a channel, with a sampler of its own, to animation `animation`, which is added if it is the next. `values` are of
/// `type` ("VEC3").
inline void animate(GltfAsset& asset, size_t animation, int node, const std::string& path, const std::vector<float>& times,
                    const std::vector<float>& values, const std::string& type, const std::string& interpolation = "LINEAR") {
    nlohmann::json& target = asset.json["animations"][animation];
    const size_t sampler = target["samplers"].size();
    const int input = asset.floats(times, "SCALAR");
    asset.json["accessors"][input]["min"] = {times.front()};
    asset.json["accessors"][input]["max"] = {times.back()};
    target["samplers"].push_back(
        {{"input", input}, {"output", asset.floats(values, type)}, {"interpolation", interpolation}});
    target["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

/// A flat bar of two quads in the plane z = 0, from y = 0 over 1 to 2, x = -0.5 and 0.5. The lower end hangs on joint 0 at
/// the origin, the upper on joint 1 at y = 1, the middle on both alike. In animation 0, "bend", joint 1 turns about z from 0
/// to 90 degrees in 2 s. Its normals are +y, so that one can see them turn. The mesh's node has a translation that means
/// nothing. Nodes: 0 joint 0, 1 joint 1, 2 the mesh; accessors: 0 positions, 1 normals, 2 joints, 3 weights, 4 indices,
/// 5 inverse bind matrices, 6 times, 7 rotations.
inline GltfAsset bendingBar() {
    GltfAsset asset;
    const int positions = asset.floats({-.5f, 0, 0, .5f, 0, 0, -.5f, 1, 0, .5f, 1, 0, -.5f, 2, 0, .5f, 2, 0}, "VEC3");
    const int normals = asset.floats({0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, "VEC3");
    const int joints = asset.accessor(
        std::vector<uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 5121);
    const int weights =
        asset.floats({1, 0, 0, 0, 1, 0, 0, 0, .5f, .5f, 0, 0, .5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    const int indices = asset.indices({0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5});
    const int mesh = asset.mesh(
        {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
         {"indices", indices}});
    const int inverse = asset.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,  //
                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                                     "MAT4");
    asset.json["skins"] = {{{"joints", {0, 1}}, {"inverseBindMatrices", inverse}}};
    asset.node({{"children", {1}}});
    asset.node({{"translation", {0, 1, 0}}});
    asset.node({{"mesh", mesh}, {"skin", 0}, {"translation", {100, 0, 0}}});
    const float half = 0.70710678f;
    animate(asset, 0, 1, "rotation", {0, 2}, {0, 0, 0, 1, 0, 0, half, half}, "VEC4");
    asset.json["animations"][0]["name"] = "bend";
    return asset;
}

/// A triangle (0,0,0) (1,0,0) (0,1,0), normals +z, with two morph targets: the first moves corner 1 by (0,0,4) and turns its
/// normal by adding (1,0,0), the second moves all by (0,8,0). The mesh's weights are 0.25 and 0; animation 0 takes node 0's
/// from (0,0) at 0 s to (1,0.5) at 1 s. Accessors: 0 positions, 1 normals, 2 to 4 targets, 5 times, 6 weights.
inline GltfAsset morphedTriangle() {
    GltfAsset asset;
    const int positions = asset.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    const int normals = asset.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const int raise = asset.floats({0, 0, 0, 0, 0, 4, 0, 0, 0}, "VEC3");
    const int turn = asset.floats({0, 0, 0, 1, 0, 0, 0, 0, 0}, "VEC3");
    const int move = asset.floats({0, 8, 0, 0, 8, 0, 0, 8, 0}, "VEC3");
    const int mesh = asset.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                                 {"targets", {{{"POSITION", raise}, {"NORMAL", turn}}, {{"POSITION", move}}}}});
    asset.json["meshes"][mesh]["weights"] = {0.25, 0};
    const int node = asset.node({{"mesh", mesh}});
    animate(asset, 0, node, "weights", {0, 1}, {0, 0, 1, 0.5f}, "SCALAR");
    return asset;
}

}  // namespace raig::test

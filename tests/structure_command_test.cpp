// Structures as the commands make, keep and choose them.
#include "base/files.hpp"
#include "structures/structure.hpp"
#include "support/gltf_asset.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace raig {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

std::string bytesOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class StructureCommands : public testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    static ProgramResult raig(const Arguments& arguments) { return runProgram(RAIG_PROGRAM, arguments); }

    /// A small picture of a scene into the file `name`, on the CPU.
    ProgramResult render(const std::string& scene, const std::string& name, const Arguments& more) const {
        Arguments all = {"render", scene, "-o", folder_ / name, "--size", "24x24", "--spp", "1", "--device", "cpu"};
        all.insert(all.end(), more.begin(), more.end());
        return raig(all);
    }
    void expectRefusal(const ProgramResult& result, int exitCode, const std::string& mentions) const {
        EXPECT_EQ(result.exitCode, exitCode) << result.errors;
        const size_t at = result.errors.find("raig: error: ");
        ASSERT_NE(at, std::string::npos) << result.errors;
        EXPECT_EQ(result.errors.find('\n', at), result.errors.size() - 1) << result.errors;
        EXPECT_NE(result.errors.find(mentions, at), std::string::npos) << result.errors << " does not mention " << mentions;
    }

    const fs::path folder_ = fs::path(testing::TempDir()) / ("structure_command_test." + std::to_string(::getpid()));
    const std::string box_ = fs::path(RAIG_SOURCE_DIR) / "assets/cornell_box.gltf";
    const std::string spheres_ = fs::path(RAIG_SOURCE_DIR) / "assets/cornell_spheres.gltf";
    const std::string file_ = folder_ / "structure";
};

TEST_F(StructureCommands, SavedStructuresGiveTheSamePicture) {
    for (const std::string& scene : {box_, spheres_}) {
        const ProgramResult saved = render(scene, "built.pfm", {"--save-structure", file_, "--json"});
        ASSERT_EQ(saved.exitCode, 0) << saved.errors;
        const ProgramResult loaded = render(scene, "loaded.pfm", {"--load-structure", file_, "--json"});
        ASSERT_EQ(loaded.exitCode, 0) << loaded.errors;
        EXPECT_EQ(bytesOf(folder_ / "loaded.pfm"), bytesOf(folder_ / "built.pfm"));
        EXPECT_NE(loaded.errors.find("read from " + file_), std::string::npos) << loaded.errors;
        const auto before = nlohmann::json::parse(saved.output), after = nlohmann::json::parse(loaded.output);
        EXPECT_EQ(after["structure"], before["structure"]);
        EXPECT_GT(before["build_s"], 0.0);
        EXPECT_EQ(before["load_s"], 0.0);
        EXPECT_EQ(after["build_s"], 0.0);
        EXPECT_GT(after["load_s"], 0.0);
    }
}

TEST_F(StructureCommands, SavedStructuresOfOtherScenesAndKindsAreRefused) {
    ASSERT_EQ(render(box_, "a.pfm", {"--save-structure", file_, "--walk", "skip", "--max-leaf", "2"}).exitCode, 0);
    EXPECT_EQ(render(box_, "b.pfm", {"--load-structure", file_, "--accel", "bvh"}).exitCode, 0);
    EXPECT_EQ(render(box_, "b.pfm", {"--load-structure", file_, "--max-leaf", "2", "--walk", "skip"}).exitCode, 0);
    expectRefusal(render(spheres_, "c.pfm", {"--load-structure", file_}), 3, "another scene");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--accel", "brute"}), 3, "holds a bvh, not the brute");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--max-leaf", "3"}), 3, "--walk skip --max-leaf 2");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", folder_ / "none"}), 3, "cannot be opened");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", box_}), 3, "is no structure");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--save-structure", file_}), 2, "excludes");
    expectRefusal(render(box_, "c.pfm", {"--save-structure", folder_ / "no/folder"}), 3, "no folder");
    fs::resize_file(file_, fs::file_size(file_) - 1);
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_}), 3, file_);
    EXPECT_FALSE(fs::exists(folder_ / "c.pfm"));
    // What is wrong with the file's start is told before the scene is read.
    expectRefusal(render("nosuch.glb", "c.pfm", {"--load-structure", file_}), 3, file_);
}

/// A glTF of a bumpy field, in nine places by EXT_mesh_gpu_instancing and once by a node of its own.
void writePlantation(const fs::path& path) {
    test::GltfAsset asset;
    std::vector<float> positions;
    std::vector<uint16_t> indices;
    for (uint16_t x = 0; x < 8; ++x)
        for (uint16_t z = 0; z < 8; ++z) {
            positions.insert(positions.end(), {0.1f * x, 0.02f * static_cast<float>(x * z % 7), 0.1f * z});
            const auto at = static_cast<uint16_t>(8 * x + z);
            for (const int corner : {0, 1, 9, 0, 9, 8})
                if (x < 7 && z < 7) indices.push_back(static_cast<uint16_t>(at + corner));
        }
    const int mesh = asset.mesh({{"attributes", {{"POSITION", asset.floats(positions, "VEC3")}}},
                                 {"indices", asset.indices(indices)}});
    std::vector<float> places, turns;
    for (int i = 0; i < 9; ++i) {
        const float half = 0.3f * static_cast<float>(i);
        places.insert(places.end(), {static_cast<float>(i % 3), 0.1f * static_cast<float>(i), static_cast<float>(i / 3)});
        turns.insert(turns.end(), {0.0f, std::sin(half), 0.0f, std::cos(half)});
    }
    asset.json["extensionsUsed"] = asset.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    asset.node({{"mesh", mesh},
                {"extensions",
                 {{"EXT_mesh_gpu_instancing",
                   {{"attributes",
                     {{"TRANSLATION", asset.floats(places, "VEC3")}, {"ROTATION", asset.floats(turns, "VEC4")}}}}}}}});
    asset.node({{"mesh", mesh}, {"scale", {-0.5, 2, 1}}});
    writeFileAtomically(path, asset.glb());
}

TEST_F(StructureCommands, KeepInstancesWithoutChangingThePicture) {
    const fs::path scene = folder_ / "plantation.glb";
    writePlantation(scene);
    const auto documentOf = [&](const char* name, const Arguments& more) {
        Arguments all = more;
        all.push_back("--json");
        const ProgramResult result = render(scene, name, all);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return nlohmann::json::parse(result.output);
    };
    const auto kept = documentOf("auto.pfm", {}), flat = documentOf("flat.pfm", {"--instances", "flatten"});
    EXPECT_EQ(kept["triangles"], 980);
    EXPECT_EQ(kept["instances"], 10);
    EXPECT_EQ(kept["structure"]["instances"], 10);
    EXPECT_EQ(kept["structure"]["references"], 98);
    EXPECT_EQ(flat["triangles"], 980);
    EXPECT_EQ(flat["structure"]["instances"], 0);
    EXPECT_EQ(flat["structure"]["references"], 980);
    EXPECT_LT(kept["structure"]["bytes"], flat["structure"]["bytes"].get<double>() / 2);
    EXPECT_EQ(bytesOf(folder_ / "auto.pfm"), bytesOf(folder_ / "flat.pfm"));
    for (const StructureType& type : structureTypes()) {
        documentOf("one.pfm", {"--instances", "keep", "--accel", std::string(type.name)});
        EXPECT_EQ(bytesOf(folder_ / "one.pfm"), bytesOf(folder_ / "flat.pfm")) << type.name;
    }
    EXPECT_EQ(documentOf("one.pfm", {"--accel", "auto"})["structure"]["instances"], 10);
    EXPECT_EQ(raig({"compare", scene, "--size", "24x24", "--device", "cpu", "--quiet"}).exitCode, 0);

    const auto told = nlohmann::json::parse(raig({"info", scene, "--json"}).output)["scene"];
    EXPECT_EQ(told["stored_triangles"], 98);
    EXPECT_EQ(told["keeps_instances"], true);
    const auto box = nlohmann::json::parse(raig({"info", box_, "--json"}).output)["scene"];
    EXPECT_EQ(box["stored_triangles"], box["triangles"]);
    EXPECT_EQ(box["keeps_instances"], false);
}

/// A file of 100 rays from `origin` into a cone around +z.
void writeRays(const fs::path& path, const std::array<float, 3>& origin) {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (100, 8), }";
    header.resize(117, ' ');
    std::ofstream file(path, std::ios::binary);
    file << "\x93NUMPY" << '\1' << '\0' << char(118) << '\0' << header << '\n';
    for (int i = 0; i < 100; ++i) {
        const float x = 0.04f * float(i % 10 - 5), y = 0.04f * float(i / 10 - 5);
        const float ray[8] = {origin[0], origin[1], origin[2], 0, x, y, 1, 1e30f};
        file.write(reinterpret_cast<const char*>(ray), sizeof ray);
    }
}

TEST_F(StructureCommands, SavedStructuresOfKeptInstancesGiveTheSamePictureAndHits) {
    const fs::path scene = folder_ / "plantation.glb", rays = folder_ / "rays.npy";
    writePlantation(scene);
    writeRays(rays, {1, 0.5f, -1.5f});
    const auto trace = [&](const char* hits, Arguments more) {
        more.insert(more.begin(), {"trace", scene, "--rays", rays, "--hits", folder_ / hits, "--json"});
        const ProgramResult result = raig(more);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const auto document = nlohmann::json::parse(result.output);
        EXPECT_GT(document["hits"], 20);
        return document["instances"].get<int>();
    };
    ASSERT_EQ(render(scene, "flat.pfm", {"--instances", "flatten"}).exitCode, 0);
    EXPECT_EQ(trace("flat.npy", {"--instances", "flatten", "--device", "cpu"}), 0);
    for (const Arguments& how : {Arguments{}, Arguments{"--instances", "keep"}, Arguments{"--accel", "auto"},
                                 Arguments{"--accel", "grid", "--levels", "1"}}) {
        Arguments saving = how;
        saving.insert(saving.end(), {"--save-structure", file_, "--json"});
        const ProgramResult saved = render(scene, "built.pfm", saving);
        ASSERT_EQ(saved.exitCode, 0) << saved.errors;
        const auto before = nlohmann::json::parse(saved.output);
        EXPECT_EQ(before["structure"]["instances"], 10);
        for (const Arguments& more : {Arguments{}, Arguments{"--instances", "keep"}}) {
            Arguments loading = more;
            loading.insert(loading.end(), {"--load-structure", file_, "--json"});
            const ProgramResult loaded = render(scene, "loaded.pfm", loading);
            ASSERT_EQ(loaded.exitCode, 0) << loaded.errors;
            const auto after = nlohmann::json::parse(loaded.output);
            EXPECT_EQ(after["structure"], before["structure"]);
            EXPECT_EQ(after["build_s"], 0.0);
            EXPECT_GT(after["load_s"], 0.0);
            EXPECT_EQ(bytesOf(folder_ / "loaded.pfm"), bytesOf(folder_ / "flat.pfm"));
        }
        for (const char* device : {"cpu", "llvmpipe"}) {
            EXPECT_EQ(trace("loaded.npy", {"--load-structure", file_, "--device", device}), 10);
            EXPECT_EQ(bytesOf(folder_ / "loaded.npy"), bytesOf(folder_ / "flat.npy")) << device;
        }
    }
}

TEST_F(StructureCommands, SavedStructuresAreOfInstancesOrOfTheSceneWrittenOut) {
    const fs::path scene = folder_ / "plantation.glb";
    writePlantation(scene);
    const std::string kept = folder_ / "kept", flat = folder_ / "flat";
    ASSERT_EQ(render(scene, "a.pfm", {"--save-structure", kept}).exitCode, 0);
    ASSERT_EQ(render(scene, "b.pfm", {"--save-structure", flat, "--instances", "flatten"}).exitCode, 0);
    EXPECT_LT(fs::file_size(kept), fs::file_size(flat));
    expectRefusal(render(scene, "c.pfm", {"--load-structure", kept, "--instances", "flatten"}), 3,
                  kept + ": is of a scene kept as instances; leave out --instances flatten");
    expectRefusal(render(scene, "c.pfm", {"--load-structure", flat, "--instances", "keep"}), 3,
                  flat + ": is of a scene written out; leave out --instances keep");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", kept}), 3, "another scene");
    EXPECT_FALSE(fs::exists(folder_ / "c.pfm"));
    for (const std::string& file : {kept, flat}) {
        const ProgramResult loaded = render(scene, "d.pfm", {"--load-structure", file, "--json"});
        ASSERT_EQ(loaded.exitCode, 0) << loaded.errors;
        EXPECT_EQ(nlohmann::json::parse(loaded.output)["structure"]["instances"], file == kept ? 10 : 0);
        EXPECT_EQ(bytesOf(folder_ / "d.pfm"), bytesOf(folder_ / "a.pfm"));
    }
    // Where nothing is kept there is one level, and the file knows that it was to be kept.
    ASSERT_EQ(render(box_, "a.pfm", {"--save-structure", kept, "--instances", "keep"}).exitCode, 0);
    ASSERT_EQ(render(box_, "b.pfm", {"--load-structure", kept}).exitCode, 0);
    EXPECT_EQ(bytesOf(folder_ / "b.pfm"), bytesOf(folder_ / "a.pfm"));
}

TEST_F(StructureCommands, InfoTellsOfTheSceneAndOfEveryStructure) {
    const ProgramResult result = raig({"info", spheres_, "--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const auto document = nlohmann::json::parse(result.output);
    const auto& scene = document["scene"];
    EXPECT_EQ(scene["file"], spheres_);
    EXPECT_EQ(scene["triangles"], 12);
    EXPECT_EQ(scene["spheres"], 2);
    EXPECT_EQ(scene["usable_triangles"], 14) << "spheres, too";
    EXPECT_GE(scene["sizes_ratio"], 1.0);
    EXPECT_FALSE(scene["features"].empty());
    EXPECT_EQ(scene["extent"].size(), 3u);
    const auto& structures = document["structures"];
    ASSERT_EQ(structures.size(), structureTypes().size());
    for (size_t i = 0; i < structures.size(); ++i) {
        const auto& found = structures[i];
        EXPECT_EQ(found["name"], std::string(structureTypes()[i].name));
        for (const char* key : {"build_s", "bytes", "nodes", "depth", "references_per_triangle", "sah", "predicted"})
            EXPECT_EQ(found.contains(key), !found.contains("trouble")) << found << ' ' << key;
        if (found["name"] == "bvh") {
            EXPECT_GT(found["nodes"], 10);
            EXPECT_EQ(found["references_per_triangle"], 1.0);
            EXPECT_GT(found["predicted"]["node_visits"], 1.0);
        }
    }
    EXPECT_FALSE(document["auto"]["structure"].get<std::string>().empty());
    EXPECT_FALSE(document["auto"]["why"].get<std::string>().empty());
}

TEST_F(StructureCommands, InfoPrintsATableThatIsAligned) {
    const ProgramResult result = raig({"info", box_});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_NE(result.output.find("triangles   "), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("\nauto: "), std::string::npos) << result.output;
    const size_t head = result.output.find("\nstructure "), bvh = result.output.find("\nbvh ");
    ASSERT_TRUE(head != std::string::npos && bvh != std::string::npos) << result.output;
    EXPECT_EQ(result.output.find('\n', head + 1) - head, result.output.find('\n', bvh + 1) - bvh) << result.output;
}

TEST_F(StructureCommands, InfoWarnsOfATeapotInAStadiumOnly) {
    const auto writeMesh = [&](const char* name, double hall) {
        std::ofstream file(folder_ / name);
        file << "v " << -hall << " 0 " << -hall << "\nv " << hall << " 0 " << -hall << "\nv 0 0 " << hall << "\nf 1 2 3\n";
        for (int x = 0; x <= 50; ++x)
            for (int z = 0; z <= 50; ++z) file << "v " << x << ' ' << 1 + x * z % 7 << ' ' << z << '\n';
        for (int x = 0; x < 50; ++x)
            for (int z = 0; z < 50; ++z) {
                const int at = 4 + 51 * x + z;
                file << "f " << at << ' ' << at + 1 << ' ' << at + 52 << ' ' << at + 51 << '\n';
            }
    };
    writeMesh("stadium.obj", 20000.0);
    writeMesh("field.obj", 60.0);
    EXPECT_NE(raig({"info", folder_ / "stadium.obj"}).errors.find("grid --levels 1 would be slow"), std::string::npos);
    EXPECT_EQ(raig({"info", folder_ / "field.obj"}).errors.find("grid --levels 1"), std::string::npos);
}

TEST_F(StructureCommands, AutoTakesTheStructureThatInfoNames) {
    for (const std::string& scene : {box_, spheres_}) {
        const auto told = nlohmann::json::parse(raig({"info", scene, "--json"}).output)["auto"];
        const std::string structure = told["structure"], line = "auto: " + structure + ": " + told["why"].get<std::string>();
        const ProgramResult result = render(scene, "auto.pfm", {"--accel", "auto", "--json", "--save-structure", file_});
        ASSERT_EQ(result.exitCode, 0) << result.errors;
        EXPECT_NE(result.errors.find(line + '\n'), std::string::npos) << result.errors << " does not say " << line;
        EXPECT_EQ(nlohmann::json::parse(result.output)["structure"]["name"], structure);
        ASSERT_EQ(render(scene, "bvh.pfm", {}).exitCode, 0);
        EXPECT_EQ(bytesOf(folder_ / "auto.pfm"), bytesOf(folder_ / "bvh.pfm"));
        EXPECT_EQ(render(scene, "loaded.pfm", {"--load-structure", file_, "--accel", structure}).exitCode, 0);
        EXPECT_EQ(render(scene, "loaded.pfm", {"--load-structure", file_, "--accel", "auto"}).exitCode, 0);
    }
    expectRefusal(render(box_, "c.pfm", {"--accel", "auto", "--max-leaf", "2"}), 2, "--max-leaf 2");
    EXPECT_EQ(render(box_, "c.pfm", {"--accel", "auto", "--memory-budget", "64"}).exitCode, 0);
}

/// What `raig trace` counts of rays that look at the box from where its camera is.
nlohmann::json countersOf(const std::string& scene, const fs::path& folder, const Arguments& more) {
    writeRays(folder / "rays.npy", {278, 273, -800});
    Arguments all = {"trace", scene, "--rays", folder / "rays.npy", "--hits", folder / "hits.npy", "--json"};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult result = runProgram(RAIG_PROGRAM, all);
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    return nlohmann::json::parse(result.output)["counters"];
}

TEST_F(StructureCommands, TraceCountsOnADeviceWhereAsked) {
    for (const char* walk : {"octants", "trail"}) {
        const nlohmann::json cpu = countersOf(box_, folder_, {"--walk", walk, "--device", "cpu"});
        EXPECT_GT(cpu["node_fetches"], 100);
        EXPECT_GT(cpu["box_tests"], 100);
        EXPECT_GT(cpu["primitive_tests"], 100);
        EXPECT_EQ(countersOf(box_, folder_, {"--walk", walk, "--device", "llvmpipe", "--counters"}), cpu);
        EXPECT_TRUE(countersOf(box_, folder_, {"--walk", walk, "--device", "llvmpipe"}).is_null());
    }
}

}  // namespace
}  // namespace raig

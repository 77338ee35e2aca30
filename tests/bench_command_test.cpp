// `raig bench` as a person or a script calls it: what is printed, what is compared, and what it exits with.
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace raig {
namespace {

using Json = nlohmann::json;

const std::string box = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";

/// With few rays.
ProgramResult bench(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"bench", box, "--side", "32", "--repeat", "2"});
    return runProgram(RAIG_PROGRAM, arguments);
}

bool isPeer(const Json& row) {
    return row.at("structure") == "embree" || row["structure"] == "driver";
}

Json benched(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const ProgramResult result = bench(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    return Json::parse(result.output);
}

TEST(BenchCommand, PrintsOneDocumentWithTheKeysOfTheDesign) {
    const Json json = benched({"--device", "cpu", "--threads", "1"});
    EXPECT_EQ(json.at("device"), "cpu");
    EXPECT_TRUE(json.at("driver").is_null());
    EXPECT_EQ(json.at("arithmetic").at("ieee"), true);
    EXPECT_EQ(json.at("machine").at("threads"), 1);
    EXPECT_TRUE(std::regex_match(json.at("commit").get<std::string>(), std::regex("unknown|[0-9a-f]{40,64}(-dirty)?")));
    ASSERT_EQ(json.at("builds").size(), 1u);
    EXPECT_GT(json["builds"][0].at("bytes"), 0);
    EXPECT_GT(json["builds"][0].at("seconds"), 0.0);

    const bool hasEmbree = json.at("peers").at("embree").at("measured");
    std::map<std::string, std::string> queries;
    for (const Json& row : json.at("results")) {
        for (const char* const quartile : {"median", "q1", "q3"}) EXPECT_GT(row.at("mrays_per_s").at(quartile), 0.0);
        EXPECT_TRUE(row.at("device_mrays_per_s").is_null()) << "the processor has no clock of its own";
        EXPECT_EQ(row.at("threads"), 1);
        EXPECT_EQ(row.at("ratio_to_embree").is_null(), !hasEmbree);
        if (isPeer(row)) continue;
        queries[row.at("rays")] = row.at("query");
        EXPECT_GT(row.at("counters").at("node_fetches"), 0);
        EXPECT_EQ(row["counters"].at("box_tests"), row["counters"]["node_fetches"]) << "a box a node";
        EXPECT_EQ(row["counters"].at("link_reads"), 0);
        if (row["rays"] == "primary") {  // others may pass all leaves by
            EXPECT_GT(row["counters"].at("primitive_tests"), 0);
        }
        if (hasEmbree) {
            EXPECT_GE(row.at("hits_embree"), 0.9 * row.at("hits").get<double>());
        }
    }
    const std::map<std::string, std::string> standard = {
        {"primary", "closest"}, {"shadow", "any"}, {"diffuse", "closest"}, {"specular", "closest"}};
    EXPECT_EQ(queries, standard);
}

TEST(BenchCommand, MeasuresEmbreeOnceInEachWay) {
    const Json json = benched({"--device", "cpu", "--accel", "all"});
    if (!json.at("peers").at("embree").at("measured")) GTEST_SKIP() << "raig was built without Embree";
    std::map<std::string, int> ways, structures;
    for (const Json& row : json.at("results")) {
        ++structures[row.at("structure")];
        if (row["structure"] != "embree") continue;
        ++ways[row.at("options")];
        EXPECT_TRUE(row.at("counters").is_null());
        EXPECT_EQ(row.at("device"), "cpu");
    }
    const std::map<std::string, int> all = {{"single", 4}, {"single robust", 4}, {"packet8", 4}, {"packet8 robust", 4}};
    EXPECT_EQ(ways, all);
    EXPECT_GE(structures.size(), 6u);
    for (const auto& [name, count] : structures) EXPECT_EQ(count, name == "embree" ? 16 : 4) << name;
}

TEST(BenchCommand, SaysWhichPeerIsMissingAndWhy) {
    const Json json = benched({"--device", "cpu"});
    EXPECT_EQ(json.at("peers").at("driver").at("measured"), false);
    EXPECT_EQ(json["peers"]["driver"].at("why"), "no device that was measured has VK_KHR_ray_query");
    const ProgramResult text = bench({"--device", "cpu"});
    EXPECT_NE(text.output.find("driver: no device that was measured has VK_KHR_ray_query"), std::string::npos)
        << text.output;
}

// What has a hit has a closest one, wherever it is looked for.
TEST(BenchCommand, AsksBothQueriesOfAllSetsOnAllDevices) {
    const Json json = benched({"--query", "all", "--device", "all"});
    std::set<std::string> devices;
    std::map<std::string, std::set<uint64_t>> hits;
    std::map<std::string, int> rows;
    for (const Json& row : json.at("results")) {
        if (isPeer(row)) continue;
        devices.insert(row.at("device"));
        hits[row.at("rays")].insert(row.at("hits").get<uint64_t>());
        ++rows[row["rays"]];
        if (row["device"] != "cpu" && !row.at("device_mrays_per_s").is_null()) {
            EXPECT_GE(row["device_mrays_per_s"].at("q3"), row.at("mrays_per_s").at("q1")) << row;
        }
    }
    EXPECT_EQ(devices.size(), json.at("devices").size());
    EXPECT_TRUE(devices.contains("cpu"));
    ASSERT_EQ(hits.size(), 4u);
    for (const auto& [rays, counts] : hits) {
        EXPECT_EQ(counts.size(), 1u) << rays;
        EXPECT_EQ(rows[rays], int(2 * devices.size())) << rays;
    }
}

TEST(BenchCommand, PrintsTablesThatFitATerminal) {
    const ProgramResult result = bench({"--device", "all"});
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    std::istringstream lines(result.output);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 125u) << line;
    for (const std::string set : {"primary, closest: 1024", "shadow, any: ", "diffuse, closest: ", "specular, closest: "})
        EXPECT_NE(result.output.find(set), std::string::npos) << set;
}

class BenchBaseline : public testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder);
        run = benched({"--device", "cpu"});
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::string written(const Json& document) const {
        std::ofstream(folder / "before.json") << document;
        return folder / "before.json";
    }
    /// The run, as if everything but Embree had been so many times as fast.
    Json scaled(double factor) const {
        Json document = run;
        for (Json& row : document["results"])
            for (const char* const key : {"ratio_to_embree", "mrays_per_s"})
                if (!isPeer(row) && !row[key].is_null()) row[key]["median"] = row[key]["median"].get<double>() * factor;
        return document;
    }
    void expectRefused(const std::vector<std::string>& arguments, int exitCode, const std::string& mentions) const {
        const ProgramResult result = runProgram(RAIG_PROGRAM, arguments);
        EXPECT_EQ(result.exitCode, exitCode) << result.errors;
        EXPECT_TRUE(result.errors.starts_with("raig: error: ")) << result.errors;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
    }

    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / ("bench_command_test." + std::to_string(::getpid()));
    Json run;
};

// Factors far beyond any noise.
TEST_F(BenchBaseline, ExitsByWhetherAnythingIsSlower) {
    const ProgramResult faster = bench({"--device", "cpu", "--baseline", written(scaled(1e-6))});
    EXPECT_EQ(faster.exitCode, 0) << faster.errors;
    EXPECT_EQ(faster.output.find("slower\n"), std::string::npos) << faster.output;
    const ProgramResult slower = bench({"--device", "cpu", "--json", "--baseline", written(scaled(1e6))});
    EXPECT_EQ(slower.exitCode, 1) << slower.errors;
    const Json baseline = Json::parse(slower.output).at("baseline");
    EXPECT_EQ(baseline.at("slower"), 4);
    EXPECT_EQ(baseline.at("commit"), run.at("commit"));
    ASSERT_EQ(baseline.at("changes").size(), 4u) << "Embree's own are not compared";
    for (const Json& change : baseline["changes"]) {
        EXPECT_EQ(change.at("metric"), run["peers"]["embree"]["measured"] ? "ratio_to_embree" : "mrays_per_s");
        EXPECT_LT(change.at("factor"), 1e-3);
        EXPECT_DOUBLE_EQ(change.at("factor"), change.at("now").get<double>() / change.at("before").get<double>());
    }
}

TEST_F(BenchBaseline, ComparesOneSlowOneAmongMany) {
    Json document = scaled(1e-6);
    for (Json& row : document["results"])
        if (!isPeer(row) && row["rays"] == "diffuse") {
            row["mrays_per_s"]["median"] = 1e9;
            row["ratio_to_embree"] = nullptr;  // then it is Mrays/s that are compared
        }
    const ProgramResult result = bench({"--device", "cpu", "--baseline", written(document), "--slower", "1000"});
    EXPECT_EQ(result.exitCode, 1) << result.errors;
    EXPECT_TRUE(std::regex_search(result.output, std::regex("diffuse .*Mrays/s .*  slower\n"))) << result.output;
    EXPECT_FALSE(std::regex_search(result.output, std::regex("primary .*  slower\n"))) << result.output;
}

TEST_F(BenchBaseline, IsRefusedBeforeAnythingIsMeasured) {
    const auto refuse = [&](const std::string& file, const std::string& mentions) {
        expectRefused({"bench", "nosuch.glb", "--baseline", file}, 3, mentions);
    };
    refuse(folder / "nosuch.json", "nosuch.json");
    refuse(folder, folder);
    refuse(box, "cornell_box.gltf: this is no document of raig bench --json");
    for (const char* const text : {"", "{", "[]", "3", "{\"results\": 3}", "{\"results\": [{}]}", "{\"results\": [7]}"}) {
        std::ofstream(folder / "wrong.json") << text;
        refuse(folder / "wrong.json", "wrong.json: ");
    }
    refuse(written(run), "nothing to compare with");  // another scene
    Json other = run;
    for (Json& row : other["results"]) row["threads"] = 999;
    expectRefused({"bench", box, "--baseline", written(other)}, 3, "nothing to compare with");
    expectRefused({"bench", box, "--slower", "2"}, 2, "--baseline");
    for (const char* const factor : {"0.5", "x", "nan", "-2"})
        expectRefused({"bench", box, "--baseline", "b", "--slower", factor}, 2, "a factor from 1 to 1000");
}

TEST_F(BenchBaseline, MustHaveSomethingInCommon) {
    expectRefused(
        {"bench", box, "--device", "cpu", "--side", "16", "--repeat", "1", "--json", "--quiet", "--baseline", written(run)},
        3, "nothing in common");
}

}  // namespace
}  // namespace raig

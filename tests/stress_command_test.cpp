// `raig stress` as a person or a script calls it: what is printed and written, and what it exits with.
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <map>
#include <set>

namespace raig {
namespace {

using Json = nlohmann::json;

ProgramResult stress(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "stress");
    return runProgram(RAIG_PROGRAM, arguments);
}

/// On the CPU, with few rays.
ProgramResult quickStress(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--device", "cpu", "--rays", "100"});
    return stress(arguments);
}

std::string textOf(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(StressCommand, PrintsOneDocumentWithTheKeysOfTheDesign) {
    const ProgramResult result = quickStress({"--case", "13", "--case", "1", "--seed", "5", "--json"});
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    const Json json = Json::parse(result.output);
    EXPECT_EQ(json.at("forbidden"), 0);
    EXPECT_EQ(json.at("broken_controls"), 0);
    EXPECT_EQ(json.at("seed"), 5);
    EXPECT_EQ(json.at("devices").at(0).at("name"), "cpu");
    EXPECT_TRUE(json.at("devices").at(0).at("arithmetic").contains("ieee"));
    std::set<int> cases;
    std::set<std::string> structures;
    size_t controls = 0;
    for (const Json& one : json.at("results")) {
        for (const char* const key : {"case", "structure", "device", "rays", "missed", "phantom", "wrong", "hung", "error"})
            EXPECT_TRUE(one.contains(key)) << key;
        EXPECT_EQ(one.at("seed"), 5);
        cases.insert(one.at("case").get<int>());
        if (one.at("control").get<bool>()) {
            ++controls;
            EXPECT_GT(one.at("percent").get<double>(), 0.0);
            EXPECT_TRUE(one.at("fails_as_it_should").get<bool>());
            EXPECT_GT(one.at("expected_percent").at("high").get<double>(), 0.0);
            continue;
        }
        structures.insert(one.at("structure").get<std::string>());
        EXPECT_EQ(one.at("rays"), 100);
        EXPECT_GT(one.at("hits").get<int>(), 50);
        for (const char* const key : {"missed", "phantom", "wrong", "differs", "any", "hung", "error"})
            EXPECT_EQ(one.at(key), 0);
    }
    EXPECT_EQ(cases, (std::set<int>{1, 13}));
    EXPECT_EQ(structures, (std::set<std::string>{"brute", "bvh", "kdtree", "bsp", "octree", "grid"}));
    EXPECT_EQ(controls, 4u);
}

TEST(StressCommand, PrintsALineForEachCaseOrEachStructure) {
    const ProgramResult result = quickStress({"--case", "14", "--accel", "octree"});
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_NE(result.output.find("at shared edges"), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("Moeller-Trumbore"), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("0 of 200 answers are wrong; 1 of 1 controls fail as they should"), std::string::npos)
        << result.output;
    const ProgramResult all = quickStress({"--case", "14", "--accel", "bvh", "-v"});
    for (const char* const one : {"brute", "--walk skip", "--bound obb"})
        EXPECT_NE(all.output.find(one), std::string::npos) << all.output;
    const ProgramResult budget = quickStress({"--case", "14", "--accel", "all", "--memory-budget", "64", "-v"});
    for (const char* const one : {"grid --memory-budget 64", "bvh --walk skip --memory-budget 64"})
        EXPECT_NE(budget.output.find(one), std::string::npos) << budget.output;
    const ProgramResult controls = quickStress({"--case", "14", "--controls"});
    EXPECT_EQ(controls.exitCode, 0);
    EXPECT_EQ(controls.output.find("answers"), std::string::npos) << controls.output;
}

TEST(StressCommand, WritesAPageItsDataAndJUnit) {
    const Folder folder;
    const std::string before = folder.write("stress.xml", "before").string();
    const std::string out = (std::filesystem::path(before).parent_path() / "a" / "report").string();
    const std::string junit = out + "/stress.xml";  // in a folder that is not there yet
    const ProgramResult result =
        quickStress({"--case", "13", "--accel", "bvh", "--walk", "skip", "-o", out, "--junit", junit, "--quiet"});
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_EQ(result.errors, "");
    const Json json = Json::parse(textOf(out + "/stress.json"));
    ASSERT_EQ(json.at("results").size(), 3u);  // brute, bvh, and a control
    EXPECT_EQ(json.at("results").at(1).at("options"), "--walk skip");
    const std::string page = textOf(out + "/index.html");
    EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
    EXPECT_TRUE(page.ends_with("</html>\n"));
    const std::string xml = textOf(junit);
    EXPECT_NE(xml.find("<testsuites tests=\"3\" failures=\"0\""), std::string::npos) << xml;
    EXPECT_NE(xml.find("classname=\"stress.controls\""), std::string::npos) << xml;
}

TEST(StressCommand, ShowsWhatEachSaysOfOneRay) {
    const ProgramResult result = quickStress({"--case", "15", "--ray", "77"});
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_NE(result.output.find("ray 77: in scene \"edges\""), std::string::npos) << result.output;
    for (const char* const one : {"exactly", "brute", "grid", "bvh --walk skip", "right"})
        EXPECT_NE(result.output.find(one), std::string::npos) << result.output;
    const Json json = Json::parse(quickStress({"--case", "15", "--ray", "77", "--json"}).output);
    const Json& ray = json.at("ray");
    for (const Json& answer : ray.at("answers")) {
        EXPECT_EQ(answer.at("closest"), ray.at("answers").at(0).at("closest"));
        EXPECT_TRUE(answer.at("faults").empty());
    }
    EXPECT_EQ(ray.at("exact").at("primitive"), ray.at("answers").at(0).at("closest").at("primitive"));
}

// Pictures, corrupt links and meshes in several places, and what of the catalogue is missing, by name.
TEST(StressCommand, RunsCasesOfOtherKindsAndNamesWhatIsMissing) {
    std::vector<std::string> arguments = {"--json"};
    for (const char* const number : {"50", "51", "52", "55", "60", "62", "63"}) {
        arguments.emplace_back("--case");
        arguments.emplace_back(number);
    }
    const ProgramResult result = quickStress(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.errors;
    const Json json = Json::parse(result.output);
    EXPECT_GE(json.at("commit").get<std::string>().size(), 7u);
    std::map<int, std::set<std::string>> structures;
    for (const Json& one : json.at("results")) {
        if (one.at("control").get<bool>()) continue;
        const int number = one.at("case");
        structures[number].insert(one.at("structure").get<std::string>());
        EXPECT_EQ(one.at("counts"), number > 51 && number < 62 ? "pixels" : "rays") << number;
        EXPECT_EQ(one.at("forbidden"), 0);
    }
    EXPECT_EQ(structures.size(), 7u);
    for (const auto& [number, names] : structures) EXPECT_EQ(names.contains("brute"), number != 62) << number;
    ASSERT_EQ(json.at("not_run").size(), 1u);
    EXPECT_EQ(json.at("not_run").at(0).at("case"), 60);
    EXPECT_NE(quickStress({"--case", "60"}).output.find("cannot be resumed yet"), std::string::npos);
}

void expectUsageError(const ProgramResult& result, const std::string& mentions, int exitCode = 2) {
    EXPECT_EQ(result.exitCode, exitCode) << result.errors;
    EXPECT_EQ(result.output, "");
    EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors;
    EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
}

TEST(StressCommand, RefusesWhatItCannotDo) {
    expectUsageError(stress({"--case", "35"}), "--case 35: there is no such case; there are 1, 2,");
    expectUsageError(stress({"--case", "52", "--ray", "1"}), "case 52 is not one of single rays");
    expectUsageError(stress({"--case", "x"}), "--case x");
    expectUsageError(stress({"--rays", "0"}), "--rays 0");
    expectUsageError(stress({"--ray", "1"}), "name that by --case");
    expectUsageError(stress({"--case", "1", "--case", "2", "--ray", "1"}), "name that by --case");
    expectUsageError(stress({"--controls", "--ray", "5", "--case", "13"}), "leave out one of them");
    expectUsageError(stress({"--controls", "--case", "22"}), "--controls: there is none");
    expectUsageError(stress({"-o", "report", "--junit", "report/stress.json"}), "written twice");
    expectUsageError(stress({"-o", "./report/", "--junit", "report/index.html"}), "written twice");
    expectUsageError(quickStress({"--case", "1", "--ray", "100"}), "--ray 100: the case has 100 rays");
    expectUsageError(stress({"--accel", "tree"}), "--accel tree");
    expectUsageError(stress({"--walk", "skip"}), "name it by --accel");
    expectUsageError(stress({"--accel", "octree", "--walk", "skip"}), "--walk");
    expectUsageError(stress({"--junit", "nowhere/x.xml"}), "nowhere", 3);
    expectUsageError(stress({"--case", "1", "-o", RAIG_PROGRAM}), "folder", 3);
    expectUsageError(stress({"--device", "no such"}), "no such", 4);
}

}  // namespace
}  // namespace raig

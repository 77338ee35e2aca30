// The command `raig stress` with structures that are broken on purpose, and with devices that are lost: what it exits with,
// and what it writes before that.
#include "app/stress_run.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "rays/tracer.hpp"
#include "support/mesh_files.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>

namespace raig {
namespace {

using Json = nlohmann::json;

std::string textOf(const std::filesystem::path& file) {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

/// As `raig stress --device cpu --accel octree --rays 60 --case ... -o FOLDER --junit FOLDER/x.xml`.
Options quick(const Folder& folder, std::vector<uint32_t> cases) {
    Options options;
    options.device = "cpu";
    options.accel = "octree";
    options.accelGiven = true;
    options.rayCount = 60;
    options.cases = std::move(cases);
    options.folder = folder.write("here", "").parent_path() / "report";
    options.junit = options.folder.parent_path() / "x.xml";
    options.quiet = true;
    return options;
}

struct Outcome {
    int exitCode = 0;
    std::string error;
    Json json;
    std::string page, junit, output;
};

Outcome run(const Options& options, const StressMakers& makers) {
    Outcome outcome;
    log::setQuiet(true);
    testing::internal::CaptureStdout();
    try {
        outcome.exitCode = stress(options, makers);
    } catch (const Error& error) {  // as main() does
        outcome.exitCode = static_cast<int>(error.exitCode);
        outcome.error = error.what();
    }
    std::fflush(stdout);
    outcome.output = testing::internal::GetCapturedStdout();
    log::setQuiet(false);
    outcome.json = Json::parse(textOf(options.folder / "stress.json"));
    outcome.page = textOf(options.folder / "index.html");
    outcome.junit = textOf(options.junit);
    return outcome;
}

/// Structures whose answers pass through `spoil(rays, hits)`, but for brute force.
template <class Spoil>
StressMakers spoiled(const Spoil& spoil) {
    StressMakers makers;
    makers.rays = [spoil](const Variant& variant, Device* device) {
        StressSubject subject = subjectOf(variant, device);
        if (variant.structure == "brute") return subject;
        subject.prepare = [prepare = subject.prepare, spoil](const hard::Scene& scene) -> AnswerRays {
            return [answer = prepare(scene), spoil](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
                answer(rays, hits, query);
                spoil(hits);
            };
        };
        return subject;
    };
    return makers;
}

uint64_t faultsOf(const Json& json, uint32_t number, const std::string& structure, const char* fault) {
    for (const Json& result : json.at("results"))
        if (result.at("case") == number && result.at("structure") == structure && !result.at("control").get<bool>())
            return result.at(fault).get<uint64_t>();
    return 0;
}

TEST(StressFailures, ExitWithNothingWhereNothingIsBroken) {
    const Folder folder;
    const Outcome outcome = run(quick(folder, {13, 52, 62}), {});
    EXPECT_EQ(outcome.exitCode, 0) << outcome.error << outcome.output;
    EXPECT_EQ(outcome.json.at("forbidden"), 0);
}

TEST(StressFailures, ExitWithOneWhereAStructureMissesHits) {
    const Folder folder;
    const Outcome outcome = run(quick(folder, {13}), spoiled([](std::span<Hit> hits) {
                                    for (Hit& hit : hits) hit = {0.0f, 0.0f, 0.0f, NO_HIT};
                                }));
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_EQ(outcome.json.at("forbidden"), 60);
    EXPECT_EQ(faultsOf(outcome.json, 13, "octree", "missed"), 60u);
    EXPECT_EQ(faultsOf(outcome.json, 13, "brute", "missed"), 0u);
    EXPECT_NE(outcome.page.find("60 of 120 answers are wrong"), std::string::npos);
    EXPECT_NE(outcome.output.find("60 of 120 answers are wrong"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.junit.find("failures=\"1\""), std::string::npos) << outcome.junit;
}

TEST(StressFailures, ExitWithOneWhereAWalkDoesNotEnd) {
    const Folder folder;
    const Structure sound = structureType("bvh").build({}, {});
    const Outcome outcome = run(quick(folder, {13}), spoiled([&](std::span<Hit>) { throw CorruptStructure(sound); }));
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_EQ(faultsOf(outcome.json, 13, "octree", "hung"), 60u);
}

TEST(StressFailures, ExitWithOneWhereAPictureIsWrong) {
    const Folder folder;
    StressMakers makers;
    makers.pictures = [](const Variant& variant, Device* device) {
        PictureSubject subject = pictureSubjectOf(variant, device);
        if (variant.structure == "brute") return subject;
        subject.render = [render = subject.render](const hard::PictureScene& scene) {
            std::vector<Picture> pictures = render(scene);
            for (Picture& picture : pictures) picture.discarded.assign(picture.discarded.size(), 0.0f);
            return pictures;
        };
        return subject;
    };
    const Outcome outcome = run(quick(folder, {52}), makers);
    EXPECT_EQ(outcome.exitCode, 1);
    // With K 0.5 at depths 15 and 30 what is discarded is less than rounding: there only the bits tell.
    EXPECT_EQ(faultsOf(outcome.json, 52, "octree", "wrong"), 256u);
    EXPECT_EQ(faultsOf(outcome.json, 52, "octree", "forbidden"), faultsOf(outcome.json, 52, "octree", "rays"));
    EXPECT_EQ(faultsOf(outcome.json, 52, "brute", "wrong"), 0u);
}

TEST(StressFailures, ExitWithOneWhereCorruptLinksAreNotNoticed) {
    const Folder folder;
    StressMakers makers;
    makers.corrupt = [](Device*) -> TraceCorrupt { return [](const Structure&, std::span<const Ray>, std::span<Hit>) {}; };
    const Outcome outcome = run(quick(folder, {62}), makers);
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_EQ(faultsOf(outcome.json, 62, "octree", "wrong"), 100u);
}

// A device that is lost with some of the cases done: those are written, and the exit code says why the others are not.
TEST(StressFailures, ExitWithFourWhereTheDeviceIsLostAndWriteWhatWasDone) {
    const Folder folder;
    auto answers = std::make_shared<int>(0);
    const auto lose = [answers](std::span<Hit>) {
        if (++*answers > 3) throw deviceError("device 'x': was lost");  // cases 13 and 14 have one scene, asked twice
    };
    const Outcome outcome = run(quick(folder, {13, 14, 52}), spoiled(lose));
    EXPECT_EQ(outcome.exitCode, 4);
    EXPECT_EQ(outcome.error, "case 14, octree on cpu: device 'x': was lost");
    EXPECT_EQ(faultsOf(outcome.json, 13, "octree", "rays"), 60u);
    EXPECT_EQ(faultsOf(outcome.json, 13, "octree", "forbidden"), 0u);
    EXPECT_EQ(faultsOf(outcome.json, 14, "octree", "error"), 60u);
    EXPECT_EQ(faultsOf(outcome.json, 52, "octree", "rays"), 0u) << "not run any more";
    EXPECT_EQ(outcome.json.at("devices").at(0).at("stopped"), outcome.error);
    EXPECT_NE(outcome.page.find("Not all was run"), std::string::npos);
    EXPECT_NE(outcome.junit.find("was lost"), std::string::npos);
}

TEST(StressFailures, ExitWithFourWhereTheDeviceIsLostInAPicture) {
    const Folder folder;
    StressMakers makers;
    makers.pictures = [](const Variant&, Device*) {
        return PictureSubject{"octree", "", [](const hard::PictureScene&) -> std::vector<Picture> {
                                  throw deviceError("device 'x': was lost");
                              }};
    };
    const Outcome outcome = run(quick(folder, {13, 52, 53}), makers);
    EXPECT_EQ(outcome.exitCode, 4);
    EXPECT_EQ(faultsOf(outcome.json, 13, "octree", "rays"), 60u);
    EXPECT_GT(faultsOf(outcome.json, 52, "octree", "error"), 0u);
    EXPECT_EQ(faultsOf(outcome.json, 53, "octree", "rays"), 0u);
}

}  // namespace
}  // namespace raig

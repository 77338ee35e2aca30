// The command `stress`: what it counts, on subjects that are broken on purpose, and what it writes.
#include "measure/stress.hpp"

#include "base/error.hpp"
#include "measure/junit.hpp"
#include "measure/stress_page.hpp"
#include "rays/tracer.hpp"
#include "support/effort.hpp"
#include "support/tracing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>

namespace raig {
namespace {

/// Changes what a sound structure answers: `spoil(ray, hit, query)`, for each.
template <class Spoil>
StressSubject spoiled(const Spoil& spoil) {
    const StressSubject sound = subjectOf({"bvh", {}}, nullptr);
    const auto prepare = [sound, spoil](const hard::Scene& scene) -> AnswerRays {
        const AnswerRays answer = sound.prepare(scene);
        return [answer, spoil](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
            answer(rays, hits, query);
            for (size_t i = 0; i < rays.size(); ++i) spoil(rays[i], hits[i], query);
        };
    };
    return {"bvh", "spoiled", prepare};
}

StressReport runWith(const StressSubject& subject, uint32_t number = 13, std::optional<uint64_t> ray = {}) {
    const StressSettings settings{.cases = {hard::caseOf(number)},
                                  .draw = {},
                                  .rays = test::affordable(400),
                                  .ray = ray,
                                  .device = "cpu",
                                  .brute = subjectOf({"brute", {}}, nullptr),
                                  .bruteOnCpu = {},
                                  .subjects = {subject}};
    return stress(settings, [](const std::string&, double done) { EXPECT_TRUE(done >= 0.0 && done <= 1.0); });
}

/// The spoiled subject's counts by fault; brute force must have none.
const StressResult& spoiledResult(const StressReport& report) {
    EXPECT_EQ(report.results.at(0).structure, "brute");
    EXPECT_EQ(report.results.at(0).forbidden(), 0u);
    return report.results.at(1);
}

/// A quarter of all rays, whatever batch they come in.
bool isChosen(const Ray& ray) {
    return ray.direction.x > 0.0f && ray.direction.y > 0.0f;
}

uint64_t chosenOf(uint32_t number) {
    uint64_t count = 0;
    for (const hard::Scene& scene : drawScenes(hard::caseOf(number), {}, test::affordable(400)))
        count += static_cast<uint64_t>(std::count_if(scene.rays.begin(), scene.rays.end(), isChosen));
    return count;
}

/// Expects that of the spoiled rays all are counted, as this fault only.
void expectCounted(const StressReport& report, StressFault fault) {
    const StressResult& result = spoiledResult(report);
    EXPECT_GT(chosenOf(13), 5u);
    for (size_t i = 1; i < stressFaults; ++i)
        EXPECT_EQ(result.counts[i], i == static_cast<size_t>(fault) ? chosenOf(13) : 0u) << stressFaultNames[i];
    EXPECT_EQ(report.forbidden(), chosenOf(13));
    EXPECT_EQ(result.rays, test::affordable(400));
    ASSERT_FALSE(result.examples.empty());
    EXPECT_EQ(result.examples[0].fault, fault);
}

TEST(Stress, CountsHitsThatAreMissed) {
    expectCounted(runWith(spoiled([](const Ray& ray, Hit& hit, Query) {
                      if (isChosen(ray)) hit = {0.0f, 0.0f, 0.0f, NO_HIT};
                  })),
                  StressFault::missed);
}

TEST(Stress, CountsHitsThatAreInTheWrongPlace) {
    expectCounted(runWith(spoiled([](const Ray& ray, Hit& hit, Query) {
                      if (isChosen(ray)) hit.t *= 1.001f;
                  })),
                  StressFault::wrong);
}

// Case 27 has rays in the planes of all triangles: nothing is hit.
TEST(Stress, CountsHitsThatAreInvented) {
    const StressReport report = runWith(spoiled([](const Ray& ray, Hit& hit, Query) {
                                            if (isChosen(ray)) hit = {1.0f, 0.25f, 0.25f, 0};
                                        }),
                                        27);
    EXPECT_EQ(spoiledResult(report).count(StressFault::phantom), chosenOf(27));
    EXPECT_EQ(report.forbidden(), chosenOf(27));
    EXPECT_GT(chosenOf(27), 0u);
}

// The oracle lets pass what rounding explains; that all structures have the same bits is asked for beside it.
TEST(Stress, CountsOtherBitsThanBruteForceHas) {
    expectCounted(runWith(spoiled([](const Ray& ray, Hit& hit, Query) {
                      if (isChosen(ray)) hit.t = std::nextafter(hit.t, 0.0f);
                  })),
                  StressFault::differs);
}

TEST(Stress, CountsAnyHitQueriesThatDisagree) {
    expectCounted(runWith(spoiled([](const Ray& ray, Hit& hit, Query query) {
                      if (isChosen(ray) && query == Query::any) hit.primitive = NO_HIT;
                  })),
                  StressFault::any);
}

TEST(Stress, CountsErrorsAndGoesOn) {
    const auto prepare = [](const hard::Scene&) -> AnswerRays { throw std::logic_error("no room"); };
    const StressSubject broken{"bvh", "", prepare};
    const StressReport report = runWith(broken);
    EXPECT_EQ(spoiledResult(report).count(StressFault::error), spoiledResult(report).rays);
    EXPECT_NE(report.results[1].examples.at(0).what.find("no room"), std::string::npos);
    EXPECT_FALSE(report.stopped.has_value());
}

StressSubject throwing(const Error& error) {
    return {"bvh", "", [error](const hard::Scene&) -> AnswerRays { throw error; }};
}

TEST(Stress, ALostDeviceEndsTheRunAndIsAnErrorOfItsCaseAndStructure) {
    const auto lost = [](const Ray& ray, Hit&, Query query) {
        if (isChosen(ray) && query == Query::any) throw deviceError("lost");
    };
    for (const StressSubject& subject : {throwing(deviceError("lost")), spoiled(lost)}) {
        const StressReport report = runWith(subject);
        const StressResult& result = spoiledResult(report);
        EXPECT_EQ(result.count(StressFault::error), result.rays);
        EXPECT_EQ(result.forbidden(), result.rays);
        ASSERT_TRUE(report.stopped.has_value());
        EXPECT_EQ(report.stopped->exitCode, ExitCode::noDevice);
        EXPECT_TRUE(std::string(report.stopped->what()).starts_with("case 13, bvh")) << report.stopped->what();
    }
    const StressSettings settings{.cases = {hard::caseOf(13), hard::caseOf(14)},
                                  .draw = {},
                                  .rays = 10,
                                  .ray = {},
                                  .device = "none",
                                  .brute = throwing(deviceError("cannot be opened")),
                                  .bruteOnCpu = {},
                                  .subjects = {subjectOf({"bvh", {}}, nullptr)}};
    const StressReport report = stress(settings, [](const std::string&, double) {});
    ASSERT_EQ(report.results.size(), 1u) << "what was not run has no result";
    EXPECT_EQ(report.results[0].count(StressFault::error), 10u);
}

TEST(Stress, ALimitEndsTheRunAndIsNoWrongAnswer) {
    const StressReport report = runWith(throwing(limitError("too large")));
    EXPECT_EQ(report.results.size(), 1u) << "brute force";
    EXPECT_EQ(report.forbidden(), 0u);
    ASSERT_TRUE(report.stopped.has_value());
    EXPECT_EQ(report.stopped->exitCode, ExitCode::limit);
    const auto runOut = [](const hard::Scene&) -> AnswerRays { throw std::bad_alloc(); };
    EXPECT_THROW(runWith({"bvh", "", runOut}), std::bad_alloc);
}

// A ray may be answered wrong by both queries: it is one that is wrong.
TEST(Stress, CountsARayOnce) {
    const StressReport report = runWith(spoiled([](const Ray&, Hit& hit, Query query) {
        hit = query == Query::closest ? Hit{0.0f, 0.0f, 0.0f, NO_HIT} : Hit{1.0f, 0.25f, 0.25f, 0};
    }));
    const StressResult& result = spoiledResult(report);
    EXPECT_EQ(result.count(StressFault::missed), result.rays);
    EXPECT_EQ(result.count(StressFault::any), result.rays);
    EXPECT_EQ(report.forbidden(), result.rays);
}

/// A structure as it is built, where the first node that is missed leads to itself.
Structure leadingAround(std::span<const Triangle> triangles) {
    Structure structure = structureType("bvh").build(triangles, {.walk = "skip"});
    for (uint32_t node = 0; node < structure.header.nodeCount; ++node)
        if (structure.nodes[2 * node].w < 0x80000000u) structure.nodes[2 * node].w = node;
    return structure;
}

TEST(Stress, TellsRaysWhoseWalkDoesNotEndFromOthers) {
    const Structure sound = structureType("bvh").build({}, {});
    const auto isRare = [](const Ray& ray) { return std::bit_cast<uint32_t>(ray.direction.x) % 16 == 0; };
    const StressReport some = runWith(spoiled([&](const Ray& ray, Hit&, Query query) {
        if (isRare(ray) && query == Query::closest) throw CorruptStructure(sound);
    }));
    uint64_t rare = 0;
    for (const hard::Scene& scene : drawScenes(hard::caseOf(13), {}, test::affordable(400)))
        rare += static_cast<uint64_t>(std::count_if(scene.rays.begin(), scene.rays.end(), isRare));
    EXPECT_GT(rare, 0u);
    EXPECT_EQ(spoiledResult(some).count(StressFault::hung), rare);
    EXPECT_EQ(some.forbidden(), rare);

    const auto prepare = [](const hard::Scene& scene) -> AnswerRays {
        const auto structure = std::make_shared<Structure>(leadingAround(scene.triangles));
        return [structure](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
            makeCpuTracer(*structure)->trace(rays, hits, query);
        };
    };
    const StressReport all = runWith({"bvh", "", prepare}, 7);
    EXPECT_GT(spoiledResult(all).count(StressFault::hung), spoiledResult(all).rays / 2);
}

// A structure is judged by itself: it does not fail for brute force's mistakes, nor is right because that is wrong, too.
TEST(Stress, JudgesWhatHasBruteForcesBitsAsBruteForce) {
    const auto spoil = [](const Ray& ray, Hit& hit, Query) {
        if (isChosen(ray)) hit = {0.0f, 0.0f, 0.0f, NO_HIT};
    };
    StressSettings settings{.cases = {hard::caseOf(13)},
                            .draw = {},
                            .rays = test::affordable(400),
                            .ray = {},
                            .device = "cpu",
                            .brute = spoiled(spoil),
                            .bruteOnCpu = subjectOf({"brute", {}}, nullptr),
                            .subjects = {spoiled(spoil), subjectOf({"bvh", {}}, nullptr)}};
    const StressReport report = stress(settings, [](const std::string&, double) {});
    EXPECT_EQ(report.results.at(0).count(StressFault::missed), chosenOf(13));
    EXPECT_EQ(report.results.at(1).count(StressFault::missed), chosenOf(13));
    EXPECT_EQ(report.results.at(2).count(StressFault::missed), 0u);
    EXPECT_EQ(report.results.at(2).count(StressFault::differs), chosenOf(13)) << "the contract asks for the same bits";
}

TEST(Stress, ARayAloneIsAnsweredAsAmongTheOthers) {
    const auto subject = [] {
        return spoiled([](const Ray& ray, Hit& hit, Query) {
            if (isChosen(ray)) hit.t *= 1.001f;
        });
    };
    for (const uint32_t number : {13, 15}) {  // of one scene, and of two
        const StressReport all = runWith(subject(), number);
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        for (const hard::Scene& scene : drawScenes(hard::caseOf(number), {}, test::affordable(400))) {
            rays.insert(rays.end(), scene.rays.begin(), scene.rays.end());
            const std::vector<Hit> some = test::traceOnCpu(structureType("brute").build(scene.triangles, {}), scene.rays);
            hits.insert(hits.end(), some.begin(), some.end());
        }
        for (const StressExample& example : all.results.at(1).examples) {
            const StressReport one = runWith(subject(), number, example.ray);
            EXPECT_EQ(one.results.at(1).rays, 1u);
            EXPECT_EQ(one.results.at(1).examples.at(0).what, example.what);
            EXPECT_EQ(one.results.at(1).examples.at(0).ray, example.ray);
            ASSERT_TRUE(one.replay.has_value());
            EXPECT_EQ(one.replay->scene, example.scene);
            EXPECT_EQ(std::memcmp(&one.replay->ray, &rays.at(example.ray), sizeof(Ray)), 0);
            EXPECT_TRUE(test::sameBits(one.replay->answers.at(0).closest, hits.at(example.ray)));
            EXPECT_TRUE(one.replay->answers[0].faults.empty());
            EXPECT_EQ(one.replay->answers.at(1).faults, std::vector{StressFault::wrong});
        }
    }
    EXPECT_THROW(runWith(subject(), 13, test::affordable(400)), Error);
}

uint64_t countOf(const std::vector<hard::Scene>& scenes) {
    uint64_t count = 0;
    for (const hard::Scene& scene : scenes) count += scene.rays.size();
    return count;
}

TEST(Stress, DrawsAsManyRaysAsAreAskedForAndOthersByTheSeed) {
    for (const hard::Case& hardCase : hard::allCases()) {
        const std::vector<hard::Scene> scenes = drawScenes(hardCase, {}, 0);
        const uint64_t all = countOf(scenes);
        for (const uint64_t count : {uint64_t{1}, all / 3, all, all + 1, 2 * all + 7})
            EXPECT_EQ(countOf(drawScenes(hardCase, {}, count)), count) << hardCase.number;
        const auto sameRays = [&](const std::vector<hard::Scene>& others) {
            return std::equal(scenes.begin(), scenes.end(), others.begin(), others.end(), [](const auto& a, const auto& b) {
                return a.rays.size() == b.rays.size() &&
                       std::memcmp(a.rays.data(), b.rays.data(), a.rays.size() * sizeof(Ray)) == 0;
            });
        };
        EXPECT_TRUE(sameRays(drawScenes(hardCase, {}, 0))) << hardCase.number;
        EXPECT_FALSE(sameRays(drawScenes(hardCase, {.seed = 1}, 0))) << hardCase.number;
    }
}

TEST(Stress, EveryStructureIsRightWhateverTheSeed) {
    StressSettings settings{.cases = hard::allCases(),
                            .draw = {.seed = 4'294'967'295},
                            .rays = test::affordable(test::isLong() ? 5000 : 100),
                            .ray = {},
                            .device = "cpu",
                            .brute = subjectOf({"brute", {}}, nullptr),
                            .bruteOnCpu = {},
                            .subjects = {}};
    // These take longer than all others together.
    const auto isSlow = [](const hard::Case& one) { return one.number == 23 || one.number == 42; };
    if (!test::isLong()) std::erase_if(settings.cases, isSlow);
    for (const StructureType& type : structureTypes())
        settings.subjects.push_back(subjectOf({std::string(type.name), {}}, nullptr));
    const StressReport report = stress(settings, [](const std::string&, double) {});
    EXPECT_EQ(report.results.size(), settings.cases.size() * (1 + structureTypes().size()));
    for (const StressResult& result : report.results)
        EXPECT_EQ(result.forbidden(), 0u) << "case " << result.number << ", " << result.structure << ": "
                                          << (result.examples.empty() ? "" : result.examples[0].what);
}

/// A run in which something of all kinds went wrong.
StressDocument badDocument() {
    StressDocument document;
    document.version = "<&\"'>\x01\xff";
    document.replay = "raig stress --seed 0";
    document.devices = {{"cpu", "", "as IEEE 754", "cpu", {}}};
    document.cases = {hard::caseOf(13), hard::caseOf(14)};
    document.results = runWith(spoiled([](const Ray& ray, Hit& hit, Query) {
                           if (isChosen(ray)) hit = {0.0f, 0.0f, 0.0f, NO_HIT};
                       })).results;
    for (const Control& control : allControls())
        if (control.number == 14) {
            document.controls.push_back({control, {.rays = 800, .missed = 91}, true});
            document.controls.push_back({control, {.rays = 800}, false});
        }
    return document;
}

TEST(StressDocument, FallsShortByAnAnswerOrAControl) {
    StressDocument document = badDocument();
    EXPECT_EQ(document.brokenControls(), 1u);
    EXPECT_EQ(document.forbidden(), chosenOf(13));
    EXPECT_TRUE(document.fellShort());
    document.controls.pop_back();
    EXPECT_TRUE(document.fellShort());
    EXPECT_NE(describeFailure(document, document.results[1]), "");
    document.results.pop_back();
    EXPECT_FALSE(document.fellShort());
    document.devices[0].stopped = limitError("too large");
    EXPECT_TRUE(document.fellShort());
    EXPECT_NE(stressPage(document).find("Not all was run on 1 of 1 devices"), std::string::npos);
    EXPECT_EQ(describeFailure(document, document.results[0]), "");
}

TEST(StressPage, LoadsNothingRunsNothingAndSaysWhatFailedFirst) {
    const StressDocument document = badDocument();
    const std::string page = stressPage(document);
    for (const char* const none : {"<script", "http", "src=", "href=", "@import", "url("})
        EXPECT_EQ(page.find(none), std::string::npos) << none;
    const size_t failures = page.find("What fell short");
    ASSERT_NE(failures, std::string::npos);
    EXPECT_LT(failures, page.find("<table"));
    EXPECT_NE(page.find(document.replayOf(document.results[1], document.results[1].examples[0].ray)), std::string::npos);
    EXPECT_NE(page.find("<td class=\"bad\">NO</td>"), std::string::npos);
    EXPECT_NE(page.find("&lt;&amp;&quot;'&gt; ?"), std::string::npos) << "escaped";
    for (const char* const open :
         {"<table", "<tr", "<td", "<th", "<div", "<details", "<summary", "<ul", "<li", "<dl", "<p"}) {
        const auto count = [&](std::string tag) {
            size_t found = 0;
            for (size_t at = page.find(tag); at != page.npos; at = page.find(tag, at + 1))
                found += page[at + tag.size()] == '>' || page[at + tag.size()] == ' ';
            return found;
        };
        EXPECT_EQ(count(open), count("</" + std::string(open + 1))) << open;
    }
}

TEST(JUnit, IsWellFormedWhateverTheTexts) {
    const std::string xml =
        junitXml("a<b", {{"g\"", "n&", 0.5, ""}, {"g", "\x01\xff\xc3\xa4 \xed\xa0\x80", 1.0, "<fail>\n]]>"}});
    EXPECT_EQ(xml,
              "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
              "<testsuites tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"0\" time=\"1.500\">\n"
              "  <testsuite name=\"a&lt;b\" tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"0\" time=\"1.500\">\n"
              "    <testcase classname=\"g&quot;\" name=\"n&amp;\" time=\"0.500\"/>\n"
              "    <testcase classname=\"g\" name=\" ?\xc3\xa4 ???\" time=\"1.000\">\n"
              "      <failure message=\"&lt;fail&gt; ]]&gt;\">&lt;fail&gt; ]]&gt;</failure>\n"
              "    </testcase>\n  </testsuite>\n</testsuites>\n");
}

}  // namespace
}  // namespace raig

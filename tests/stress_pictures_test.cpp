// The hard cases that pictures show: all structures pass them, and what is broken does not.
#include "measure/stress_pictures.hpp"

#include "base/error.hpp"
#include "support/devices.hpp"
#include "support/effort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace raig {
namespace {

StressReport runWith(std::vector<PictureSubject> subjects, std::vector<hard::PictureCase> cases, bool isDevice = false) {
    const PictureSettings settings{
        .cases = std::move(cases), .draw = {}, .device = "x", .isDevice = isDevice, .subjects = std::move(subjects)};
    return stressPictures(settings, [](const std::string&, double done) { EXPECT_TRUE(done >= 0.0 && done <= 1.0); });
}

hard::PictureCase caseOf(uint32_t number) {
    for (const hard::PictureCase& one : hard::pictureCases())
        if (one.number == number) return one;
    throw std::logic_error("no such case");
}

/// Pictures of the sound bvh, changed.
template <class Spoil>
PictureSubject spoiled(const Spoil& spoil) {
    PictureSubject subject = pictureSubjectOf({"bvh", {}}, nullptr);
    subject.render = [render = subject.render, spoil](const hard::PictureScene& scene) {
        std::vector<Picture> pictures = render(scene);
        for (Picture& picture : pictures) spoil(picture);
        return pictures;
    };
    return subject;
}

/// The pictures of another scene, made out of the one that is asked for.
template <class Change>
PictureSubject ofAnother(const Change& change) {
    PictureSubject subject = pictureSubjectOf({"bvh", {}}, nullptr);
    subject.render = [render = subject.render, change](hard::PictureScene scene) {
        change(scene.scene);
        return render(scene);
    };
    return subject;
}

TEST(StressPictures, AreRightWithEveryStructure) {
    std::vector<PictureSubject> subjects;
    for (const StructureType& type : structureTypes())
        subjects.push_back(pictureSubjectOf({std::string(type.name), {}}, nullptr));
    const StressReport report = runWith(subjects, hard::pictureCases());
    EXPECT_EQ(report.results.size(), (hard::pictureCases().size() - 2) * subjects.size()) << "57 and 59 are for devices";
    for (const StressResult& result : report.results) {
        EXPECT_EQ(result.forbidden(), 0u) << "case " << result.number << ", " << result.structure << ": "
                                          << (result.examples.empty() ? "" : result.examples[0].what);
        EXPECT_GT(result.rays, 30u);
    }
}

// Each case tells pictures that are a little off: what it asks is known of nearly all pixels.
TEST(StressPictures, NoticePixelsThatAreALittleOff) {
    const PictureSubject brute = pictureSubjectOf({"brute", {}}, nullptr);
    const PictureSubject brighter = spoiled([](Picture& picture) {
        for (vec3& pixel : picture.radiance) pixel = 1.01f * pixel + 0.001f;
    });
    for (const hard::PictureCase& one : hard::pictureCases()) {
        if (one.number == 57 || one.number == 59) continue;  // for devices
        const StressReport report = runWith({brute, brighter}, {one});
        const StressResult& result = report.results.at(1);
        EXPECT_GE(result.forbidden(), result.rays * 95 / 100) << one.number;
        // Case 60 knows nothing of the pictures but that they are alike.
        if (one.number != 60) {
            EXPECT_GE(result.count(StressFault::wrong), result.rays * 90 / 100) << one.number;
        }
        ASSERT_FALSE(result.examples.empty());
    }
}

TEST(StressPictures, NoticePixelsThatAreNoNumbers) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const bool ofWeight : {false, true}) {
        const StressReport report = runWith({spoiled([&](Picture& picture) {
                                                if (ofWeight)
                                                    picture.discarded[0] = nan;
                                                else
                                                    picture.radiance[0].y = nan;
                                            })},
                                            {caseOf(60)});
        EXPECT_EQ(report.results.at(0).count(StressFault::wrong), 12u) << "one a picture";
    }
}

TEST(StressPictures, NoticeOtherBits) {
    int number = 0;
    const StressReport report = runWith({pictureSubjectOf({"brute", {}}, nullptr), spoiled([&](Picture& picture) {
                                             if (number++ == 2)
                                                 picture.radiance[5].x = std::nextafter(picture.radiance[5].x, 9.0f);
                                         })},
                                        {caseOf(60)});
    EXPECT_EQ(report.results.at(0).forbidden(), 0u);
    EXPECT_EQ(report.results.at(1).count(StressFault::differs), 1u);
}

// What would be seen of the mistakes that the cases are for.
TEST(StressPictures, NoticeTheMistakesTheyAreFor) {
    const auto wrongOf = [](uint32_t number, const PictureSubject& subject) {
        const StressResult result = runWith({subject}, {caseOf(number)}).results.at(0);
        return double(result.count(StressFault::wrong)) / double(result.rays);
    };
    EXPECT_GT(wrongOf(52, spoiled([](Picture& picture) {
                          for (float& weight : picture.discarded) weight *= 0.5f;
                      })),
              0.7)
        << "weight that was cut off and not told";
    EXPECT_GT(wrongOf(53, spoiled([](Picture& picture) {
                          for (float& weight : picture.discarded) weight = 0.0f;
                      })),
              0.6)
        << "not of paths that were not cut off";
    EXPECT_GT(wrongOf(54, ofAnother([](Scene& scene) {
                          for (Material& material : scene.materials) material.baseColor = vec3(0.99f);
                      })),
              0.2)
        << "light that is lost in glass";
    EXPECT_GT(wrongOf(54, ofAnother([](Scene& scene) {
                          if (scene.materials.size() == 2) scene.materials[1].ior *= 1.01f;  // the far side of a slab
                      })),
              0.1)
        << "bent back by another index than it was bent by";
    EXPECT_GT(wrongOf(55, ofAnother([](Scene& scene) {
                          scene.cameras[0].eye += 0.001f * scene.cameras[0].forward;  // beyond what it lay on
                      })),
              0.3);
    EXPECT_GT(wrongOf(56, ofAnother([](Scene& scene) {
                          scene.meshes.back().spheres.clear(), scene.meshes.back().materials.clear();
                      })),
              0.5)
        << "light that passes through what absorbs as if it were not there";
    EXPECT_GT(wrongOf(58, spoiled([](Picture& picture) {
                          if (picture.radiance.size() > 8)
                              std::rotate(picture.radiance.begin(), picture.radiance.begin() + 1, picture.radiance.end());
                      })),
              0.3)
        << "pixels in the place of others, which in a picture 65536 wide look much the same";
}

TEST(StressPictures, CountErrorsAndGoOn) {
    const PictureSubject broken{"bvh", "",
                                [](const hard::PictureScene&) -> std::vector<Picture> { throw std::logic_error("oh"); }};
    const StressReport report = runWith({broken}, {caseOf(52), caseOf(53)});
    EXPECT_FALSE(report.stopped.has_value());
    ASSERT_EQ(report.results.size(), 2u);
    for (const StressResult& result : report.results) EXPECT_EQ(result.count(StressFault::error), result.rays);
    EXPECT_NE(report.results[0].examples.at(0).what.find("oh"), std::string::npos);
}

TEST(StressPictures, EndWhereTheDeviceIsLostOrALimitIsReached) {
    const auto throwing = [](const Error& error) {
        return PictureSubject{"bvh", "", [error](const hard::PictureScene&) -> std::vector<Picture> { throw error; }};
    };
    const StressReport lost = runWith({throwing(deviceError("gone"))}, {caseOf(52), caseOf(53)});
    ASSERT_TRUE(lost.stopped.has_value());
    EXPECT_EQ(lost.stopped->exitCode, ExitCode::noDevice);
    ASSERT_EQ(lost.results.size(), 1u);
    EXPECT_GT(lost.results[0].count(StressFault::error), 0u);
    const StressReport limit = runWith({throwing(limitError("full"))}, {caseOf(52)});
    ASSERT_TRUE(limit.stopped.has_value());
    EXPECT_EQ(limit.stopped->exitCode, ExitCode::limit);
    EXPECT_TRUE(limit.results.empty()) << "a limit is no wrong answer";
}

// Case 59 asks for limits to be told: a picture instead is a fault.
TEST(StressPictures, WantScenesRefusedThatExceedALimit) {
    const StressReport ignored = runWith({pictureSubjectOf({"bvh", {}}, nullptr)}, {caseOf(59)}, /* isDevice= */ true);
    EXPECT_EQ(ignored.results.at(0).count(StressFault::wrong), 1u) << "the CPU knows no such limit";
    EXPECT_EQ(ignored.results[0].examples.at(0).what, "was not refused");
}

TEST(StressCorruption, WantsCorruptLinksToBeTold) {
    std::vector<Variant> variants;
    for (const StructureType& type : structureTypes()) variants.push_back({std::string(type.name), {}});
    const StressReport sound = stressCorruption(variants, corruptTraceOf(nullptr), {}, "cpu", 0);
    EXPECT_EQ(sound.results.size(), structureTypes().size() - 1) << "brute has no links";
    EXPECT_EQ(sound.forbidden(), 0u);
    const auto ignore = [](const Structure&, std::span<const Ray>, std::span<Hit>) {};
    const StressReport ignored = stressCorruption(variants, ignore, {}, "cpu", 0);
    for (const StressResult& result : ignored.results) EXPECT_EQ(result.count(StressFault::wrong), result.rays);
    const auto lose = [](const Structure&, std::span<const Ray>, std::span<Hit>) { throw deviceError("gone"); };
    const StressReport lost = stressCorruption(variants, lose, {}, "cpu", 0);
    EXPECT_TRUE(lost.stopped.has_value());
    EXPECT_EQ(lost.results.size(), 1u);
}

class StressPicturesOnDevices : public OnEveryDevice {};

TEST_P(StressPicturesOnDevices, AreRight) {
    Device device(info);
    const PictureSubject bvh = pictureSubjectOf({"bvh", {}}, &device);
    const StressReport report = runWith({bvh}, {caseOf(52), caseOf(59)}, /* isDevice= */ true);
    EXPECT_FALSE(report.stopped.has_value());
    for (const StressResult& result : report.results)
        EXPECT_EQ(result.forbidden(), 0u) << "case " << result.number << ": "
                                          << (result.examples.empty() ? "" : result.examples[0].what);
    EXPECT_EQ(bvh.render(caseOf(59).make({}).at(0)).size(), 1u) << "its arrays are split, not refused";
}

INSTANTIATE_TEST_SUITE_P(, StressPicturesOnDevices, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig

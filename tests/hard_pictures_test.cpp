// The hard cases that pictures show, each by its number in the catalogue, on the processor and on every device.
#include "base/error.hpp"
#include "measure/stress_pictures.hpp"
#include "support/devices.hpp"
#include "support/ways.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

/// The ways that pictures of the stress cases are made: no reference, as what is known of them needs none.
std::vector<std::string> renderers() {
    std::vector<std::string> names = {"cpu"};
    for (const std::string& device : devicesToTest()) names.push_back(device);
    return names;
}

std::vector<uint32_t> numbers() {
    std::vector<uint32_t> all;
    for (const hard::PictureCase& one : hard::pictureCases())
        if (one.number != 57) all.push_back(one.number);  // of item buffers: in their own test
    return all;
}

class HardPicture : public testing::TestWithParam<std::tuple<uint32_t, std::string>> {};

TEST_P(HardPicture, IsAsItMustBe) {
    const auto& [number, name] = GetParam();
    std::unique_ptr<Device> device;
    if (name != "cpu") {
        const std::optional<DeviceInfo> info = findDevice(name);
        if (!info) GTEST_SKIP() << "there is no device " << name;
        device = std::make_unique<Device>(*info);
    } else if (number == 59) {
        GTEST_SKIP() << "the processor binds no arrays";
    }
    PictureSettings settings{.cases = {}, .draw = {}, .device = name, .isDevice = device != nullptr, .subjects = {}};
    for (const hard::PictureCase& one : hard::pictureCases())
        if (one.number == number) settings.cases.push_back(one);
    settings.subjects = {pictureSubjectOf({"bvh", {}}, device.get())};
    const StressReport report = stressPictures(settings, [](const std::string&, double) {});
    ASSERT_EQ(report.results.size(), 1u);
    const StressResult& result = report.results[0];
    EXPECT_EQ(result.forbidden(), 0u) << (result.examples.empty() ? "" : result.examples[0].what);
    EXPECT_GT(result.rays, 0u);
    EXPECT_FALSE(report.stopped.has_value());
}

INSTANTIATE_TEST_SUITE_P(, HardPicture, testing::Combine(testing::ValuesIn(numbers()), testing::ValuesIn(renderers())),
                         [](const auto& info) {
                             return "Case" + std::to_string(std::get<0>(info.param)) + "On" + std::get<1>(info.param);
                         });

// The catalogue's section on shading, pictures and machines: which of its cases are run as rays, and which as pictures. The
// item buffer (57) has a test of its own, and so do corrupted links (62).
TEST(HardCases50To61, AreAllRun) {
    std::vector<uint32_t> known = numbers();
    for (const hard::Case& one : hard::laterCases()) known.push_back(one.number);
    for (const uint32_t number : {50u, 51u, 52u, 53u, 54u, 55u, 56u, 58u, 59u, 60u, 61u})
        EXPECT_TRUE(std::ranges::find(known, number) != known.end()) << "case " << number;
}

}  // namespace
}  // namespace raig

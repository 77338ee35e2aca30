// Which walk of bvh a device is given.
#include "measure/walk_choice.hpp"

#include "base/files.hpp"
#include "support/devices.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace raig {
namespace {

namespace fs = std::filesystem;

TEST(FastestWalk, IsTheFirstUnlessAnotherIsClearlyFaster) {
    EXPECT_EQ(fastestOf({1.0, 2.0, 3.0, 4.0}), 0u);
    EXPECT_EQ(fastestOf({1.0, 2.0, 0.95, 4.0}), 0u);
    EXPECT_EQ(fastestOf({1.0, 2.0, 0.85, 4.0}), 2u);
    EXPECT_EQ(fastestOf({1.0, 0.8, 0.7, 0.6}), 3u);
    EXPECT_EQ(fastestOf({1.0, 0.0, 0.7, 0.0}), 2u) << "two of them were not tried";
}

class WalkChoiceOnEveryDevice : public OnEveryDevice {
protected:
    void SetUp() override {
        OnEveryDevice::SetUp();
        if (const char* given = std::getenv("XDG_CACHE_HOME")) before_ = given;
        fs::create_directories(folder_);
        setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
    }
    void TearDown() override {
        if (before_)
            setenv("XDG_CACHE_HOME", before_->c_str(), 1);
        else
            unsetenv("XDG_CACHE_HOME");
        fs::remove_all(folder_);
        OnEveryDevice::TearDown();
    }

    /// What is kept of the choice; not the pipelines.
    fs::path kept() const {
        for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / "raig"))
            if (entry.path().filename().string().starts_with("kept-")) return entry.path();
        return {};
    }

    static bool isKnown(const WalkChoice& choice) { return choice.why.find("earlier run") != std::string::npos; }

    const fs::path folder_ = fs::path(testing::TempDir()) / ("walk_choice_test." + std::to_string(::getpid()));
    std::optional<std::string> before_;
};

TEST_P(WalkChoiceOnEveryDevice, IsMeasuredOnceAndAgainWhereWhatIsKeptIsNotWhole) {
    Device device(info);
    const WalkChoice measured = chooseWalk(device, "1");
    EXPECT_FALSE(isKnown(measured)) << measured.why;
    EXPECT_NO_THROW(structureType("bvh").build({}, {.walk = measured.walk, .arity = measured.arity}));
    ASSERT_FALSE(kept().empty());

    const WalkChoice known = chooseWalk(device, "1");
    EXPECT_TRUE(isKnown(known)) << known.why;
    EXPECT_EQ(known.walk, measured.walk);
    EXPECT_EQ(known.arity, measured.arity);

    std::vector<std::byte> bytes = readFile(kept());
    bytes.back() ^= std::byte{1};
    std::ofstream(kept(), std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
    EXPECT_FALSE(isKnown(chooseWalk(device, "1"))) << "one bit of the file is wrong";
    EXPECT_TRUE(isKnown(chooseWalk(device, "1"))) << "it is whole again";
    EXPECT_FALSE(isKnown(chooseWalk(device, "2"))) << "measured by another version";
}

INSTANTIATE_TEST_SUITE_P(, WalkChoiceOnEveryDevice, testing::ValuesIn(devicesToTest()), testName);

// On the CPU the walk is fixed: the same every time, without measuring.
TEST(WalkOnCpu, IsOneThatBvhOffers) {
    const WalkChoice choice = walkOnCpu();
    EXPECT_NO_THROW(structureType("bvh").build({}, {.walk = choice.walk, .arity = choice.arity}));
}

}  // namespace
}  // namespace raig

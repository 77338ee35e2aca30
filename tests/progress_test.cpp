// What the progress bar draws, and that it stays silent where no person watches.
#include "app/progress.cpp"  // the program's own files are in no library

#include <gtest/gtest.h>

#include <string>

namespace raig {

namespace {

TEST(ProgressLine, SaysShareRateAndTimeLeft) {
    // A quarter of the work, 30 million rays in 10 seconds: 3 Mrays/s, and 30 seconds to go.
    const std::string line = progressLine("render", 0.25, 30e6, 10.0, 90);
    EXPECT_TRUE(line.starts_with("render [##########..............................]  25 %")) << line;
    EXPECT_NE(line.find("3.00 Mrays/s"), std::string::npos) << line;
    EXPECT_TRUE(line.ends_with("30 s left")) << line;
}

TEST(ProgressLine, FitsAnyWidth) {
    for (const double fraction : {-1.0, 0.0, 1e-9, 0.5, 0.999, 1.0, 2.0})
        for (size_t columns = 0; columns <= 200; ++columns)
            EXPECT_LE(progressLine("render", fraction, 1e9, 3600.0, columns).size(), columns);
}

TEST(ProgressLine, GivesUpTheBarBeforeTheNumbers) {
    const std::string line = progressLine("render", 0.5, 30e6, 10.0, 45);
    EXPECT_EQ(line.find('['), std::string::npos) << line;
    EXPECT_TRUE(line.ends_with("10 s left")) << line;
}

TEST(ProgressLine, NeverShowsAllDoneBeforeItIs) {
    EXPECT_NE(progressLine("render", 0.9999, 1e6, 1.0, 79).find(" 99 %"), std::string::npos);
    EXPECT_NE(progressLine("render", 1.0, 1e6, 1.0, 79).find("100 %"), std::string::npos);
}

TEST(ProgressLine, SaysNothingItCannotKnow) {
    const std::string line = progressLine("render", 0.0, 0.0, 0.0, 79);
    EXPECT_EQ(line.find("left"), std::string::npos) << line;
    EXPECT_EQ(line.find("Mrays"), std::string::npos) << line;
}

TEST(ProgressLine, WritesLongTimesAsClocks) {
    EXPECT_NE(progressLine("", 0.5, 0.0, 185.0, 79).find("3:05 left"), std::string::npos);
    EXPECT_NE(progressLine("", 0.5, 0.0, 7385.0, 79).find("2:03:05 left"), std::string::npos);
}

TEST(Progress, DrawsNothingWhereNoTerminalIs) {
    testing::internal::CaptureStderr();  // a file
    {
        Progress progress("render");
        for (int i = 0; i <= 7; ++i) {
            progress.update(i / 7.0, 1e6 * i);
            ::usleep(100'000);
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace

}  // namespace raig

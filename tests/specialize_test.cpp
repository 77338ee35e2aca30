// What drivers are given of a kernel: that of it which its specialization constants leave.
#include "device/specialize.hpp"
#include "rays/kernels.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

constexpr uint32_t specTrue = 48, specOp = 52;  // OpSpecConstantTrue to OpSpecConstantOp

/// How many instructions of `spirv` have an opcode from `first` to `last`.
size_t countOf(std::span<const uint32_t> spirv, uint32_t first, uint32_t last) {
    size_t count = 0;
    for (size_t i = 5; i < spirv.size(); i += spirv[i] >> 16) {  // five words come before the first
        const uint32_t opcode = spirv[i] & 0xffffu;
        count += opcode >= first && opcode <= last;
        if (spirv[i] >> 16 == 0) return 0;
    }
    return count;
}

TEST(Specialize, LeavesNoConstantOpenAndLessCode) {
    const std::span<const uint32_t> spirv = findKernel("trace_bvh_storage").value();
    ASSERT_GT(countOf(spirv, specTrue, specOp), 10u);
    const std::vector<uint32_t> one = vk::specialize("one", spirv, {{0, 64}, {3, 0}});
    const std::vector<uint32_t> other = vk::specialize("other", spirv, {{0, 64}, {3, 4}, {4, 1}});
    EXPECT_EQ(countOf(one, specTrue, specOp), 0u);
    EXPECT_EQ(countOf(other, specTrue, specOp), 0u);
    EXPECT_LT(one.size(), spirv.size());
    EXPECT_LT(other.size(), spirv.size());
    EXPECT_NE(one, other);
    EXPECT_EQ(one, vk::specialize("again", spirv, {{0, 64}, {3, 0}}));
}

TEST(SpecializeDeathTest, RefusesWhatIsNoCode) {
    const std::vector<uint32_t> noise(100, 0x12345678u);
    EXPECT_DEATH(vk::specialize("noise", noise, {}), "noise");
}

}  // namespace
}  // namespace raig

// Kernels: what does not match them is refused, what they compute with is measured, and what they are compiled to is kept.
#include "base/files.hpp"
#include "device/arithmetic.hpp"
#include "device/cache.hpp"
#include "device/commands.hpp"
#include "support/devices.hpp"
#include "support/selftest.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace raig {
namespace {

using namespace test;

// ---- Refusals ------------------------------------------------------------------------------------------------------------

class Refusals : public OnEveryDevice {
protected:
    Refusals() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }  // drivers have threads, which fork() would lose
};

TEST_P(Refusals, OfBindingsThatDoNotMatchTheKernel) {
    Device device(info, quick());
    Kernel kernel(device, "selftest_load", loadKernel(device.loadsTexel()), {{0, 8}});
    Buffer buffer(device, 1024);
    EXPECT_DEATH(kernel.bind(5, buffer), "binding 5 is declared");
    EXPECT_DEATH(kernel.bind(0, buffer), "binding 0 is one buffer");
    const BigArray array(device, someBytes(64));
    Commands commands(device);
    EXPECT_DEATH(commands.dispatch(kernel, {1}, LoadPush{0, 1}), "binding 0 .*is bound");
    kernel.bind(0, array);
    EXPECT_DEATH(commands.dispatch(kernel, {1}, LoadPush{0, 1}), "binding 1 .*is bound");
    { kernel.bind(1, Buffer(device, 64)); }
    EXPECT_DEATH(commands.dispatch(kernel, {1}, LoadPush{0, 1}), "the buffer of binding 1 exists");
}

TEST_P(Refusals, OfArraysMadeForTheOtherForm) {
    Device storage(info, quick({.loadsTexel = false}));
    Kernel kernel(storage, "selftest_load", loadKernel(/* texel= */ true), {{0, 8}});
    const BigArray array(storage, someBytes(64));
    EXPECT_DEATH(kernel.bind(0, array), "made for descriptors of its kind");
    Device other(info, quick());
    EXPECT_DEATH(kernel.bind(1, Buffer(other, 64)), "is its device's");
}

TEST_P(Refusals, OfPushConstantsAndGroupsThatDoNotFit) {
    Device device(info, quick());
    Kernel kernel(device, "selftest_load", loadKernel(device.loadsTexel()), {{0, 8}});
    Commands commands(device);
    const struct Short { uint32_t first; } tooShort{0};
    EXPECT_DEATH(commands.dispatch(kernel, {1}, tooShort), "push.size\\(\\) \\(4\\)");
    EXPECT_DEATH(commands.dispatch(kernel, {1}), "push.size\\(\\) \\(0\\)");
    if (info.limits.workgroupCount[1] == 0xffffffffu) return;  // any number is allowed
    EXPECT_DEATH(commands.dispatch(kernel, {1, info.limits.workgroupCount[1] + 1}, LoadPush{0, 1}), "groups");
}

TEST_P(Refusals, OfWorkgroupsAndConstantsThatDoNotFit) {
    Device device(info, quick());
    const auto make = [&](const Constants& constants) { Kernel(device, "k", loadKernel(device.loadsTexel()), constants); };
    EXPECT_DEATH(make({{0, info.limits.workgroupSize[0] + 1}}), "workgroup size");
    EXPECT_DEATH(make({{0, 0}}), "workgroup size 0");
    EXPECT_DEATH(make({{17, 1}}), "specialization constant 17 is declared");
}

TEST_P(Refusals, OfTransfersBeyondABuffer) {
    Device device(info, quick());
    Buffer buffer(device, 64);
    EXPECT_DEATH(buffer.upload(someBytes(68)), "bytes");
    EXPECT_DEATH(buffer.upload(someBytes(4), 64), "bytes");
    EXPECT_DEATH(buffer.upload(someBytes(4), ~uint64_t{3}), "offset");
    EXPECT_DEATH(buffer.upload(someBytes(3)), "% 4");
}

TEST(Reflection, TellsWhatAKernelDeclares) {
    for (const bool texel : {false, true}) {
        const KernelInterface found = reflect("selftest_load", loadKernel(texel), {{0, 24}, {1, 3}});
        ASSERT_EQ(found.bindings.size(), 2u);
        EXPECT_EQ(found.bindings.at(0).kind, texel ? KernelBinding::Kind::texel : KernelBinding::Kind::storage);
        EXPECT_EQ(found.bindings.at(0).count, 4u);
        EXPECT_EQ(found.bindings.at(1).kind, KernelBinding::Kind::storage);
        EXPECT_EQ(found.bindings.at(1).count, 1u);
        EXPECT_TRUE(found.bindings.at(0).used && found.bindings.at(1).used);
        EXPECT_EQ(found.pushBytes, sizeof(LoadPush));
        EXPECT_EQ(found.workgroupSize, (std::array<uint32_t, 3>{24, 1, 1}));
        EXPECT_EQ(found.constants, (std::map<uint32_t, uint32_t>{{0, 24}, {1, 3}, {2, 31}}));
    }
    EXPECT_EQ(reflect("selftest", findKernel("selftest_storage").value(), {}).workgroupSize,
              (std::array<uint32_t, 3>{64, 1, 1}));
}

// ---- Arithmetic ----------------------------------------------------------------------------------------------------------

TEST_P(OnEveryDevice, ArithmeticIsMeasuredAlikeEachTime) {
    Device device(info, quick());
    const Arithmetic found = measureArithmetic(device, findKernel("selftest_storage").value());
    EXPECT_GT(found.samples, 10'000u);
    EXPECT_EQ(found, measureArithmetic(device, findKernel("selftest_storage").value()));
    if (info.type != DeviceType::software) return;  // hardware divides and takes roots as it likes

    EXPECT_TRUE(found.ieee());
    EXPECT_TRUE(found.addExact && found.subExact && found.mulExact && found.divExact && found.sqrtExact);
    EXPECT_TRUE(found.divisionByZero && found.intToFloatExact && found.floatToIntExact);
    EXPECT_EQ(found.contraction, "none");
    EXPECT_EQ(found.fma, "unfused");
    const bool lavapipe = GetParam() == "llvmpipe";
    EXPECT_EQ(found.denormals, lavapipe ? "kept" : "flushed");
    EXPECT_EQ(found.minMaxNan, lavapipe ? "number" : "second");
}

TEST(Arithmetic, OfTheCpuIsIeee) {
    const Arithmetic found = measureHostArithmetic();
    EXPECT_TRUE(found.ieee());
    EXPECT_TRUE(found.intToFloatExact && found.uintToFloatExact && found.floatToIntExact && found.divisionByZero);
    EXPECT_EQ(found.denormals, "kept");
    EXPECT_EQ(found.contraction, "none");
    EXPECT_EQ(found.fma, "fused");
}

#ifdef __SSE__
// The measurement sees what it claims to see: here is a processor that flushes.
TEST(Arithmetic, ShowsAProcessorThatFlushesDenormals) {
    const unsigned before = _mm_getcsr();
    for (const unsigned mode : {0x8000u, 0x0040u, 0x8040u}) {  // results, operands, both
        _mm_setcsr(before | mode);
        const Arithmetic found = measureHostArithmetic();
        _mm_setcsr(before);
        EXPECT_EQ(found.denormals, "flushed") << mode;
        EXPECT_TRUE(found.ieee()) << mode;
    }
}
#endif

// ---- The cache of pipelines ----------------------------------------------------------------------------------------------

TEST(PipelineCache, DamagedFilesAreNotUsed) {
    const std::vector<std::byte> blob = someBytes(100);
    const std::vector<std::byte> file = vk::encodeCache(blob, "key");
    EXPECT_EQ(vk::decodeCache(file, "key"), blob);
    EXPECT_EQ(vk::decodeCache(file, "another key"), std::nullopt);
    EXPECT_EQ(vk::decodeCache(vk::encodeCache({}, "key"), "key"), std::vector<std::byte>());
    for (size_t length = 0; length < file.size(); ++length)
        EXPECT_EQ(vk::decodeCache(std::span(file).first(length), "key"), std::nullopt) << length;
    for (size_t i = 0; i < file.size(); ++i) {
        std::vector<std::byte> damaged = file;
        damaged[i] ^= std::byte{1};
        EXPECT_EQ(vk::decodeCache(damaged, "key"), std::nullopt) << i;
    }
    std::vector<std::byte> longer = file;
    longer.push_back(std::byte{0});
    EXPECT_EQ(vk::decodeCache(longer, "key"), std::nullopt);
}

/// Sets environment variables (null: unsets) and puts them back.
class ScopedVariable {
public:
    ScopedVariable(const char* name, const char* value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        value ? ::setenv(name, value, 1) : ::unsetenv(name);
    }
    ~ScopedVariable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }

private:
    const char* name_;
    std::optional<std::string> before_;
};

TEST(PipelineCache, LiesInTheUsersCacheFolder) {
    const ScopedVariable home("HOME", "/home/someone");
    {
        const ScopedVariable cache("XDG_CACHE_HOME", "/var/cache/someone");
        EXPECT_EQ(vk::cacheFile("key").parent_path(), "/var/cache/someone/raig");
        EXPECT_NE(vk::cacheFile("key"), vk::cacheFile("other"));
    }
    for (const char* unusable : {static_cast<const char*>(nullptr), "", "relative"}) {
        const ScopedVariable cache("XDG_CACHE_HOME", unusable);
        EXPECT_EQ(vk::cacheFile("key").parent_path(), "/home/someone/.cache/raig");
        const ScopedVariable noHome("HOME", nullptr);
        EXPECT_TRUE(vk::cacheFile("key").empty());
    }
}

TEST_P(OnEveryDevice, ADamagedCacheIsReplacedAndAnUnwritableOneIgnored) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / fmt::format("raig_cache_{}_{}", GetParam(), ::getpid());
    std::filesystem::create_directories(folder);
    const ScopedVariable cache("XDG_CACHE_HOME", folder.c_str());
    const auto compile = [&] {
        Device device(info);
        Kernel(device, "selftest_load", loadKernel(device.loadsTexel()), {{0, 8}});
        return device.state().cacheFile;
    };
    const std::string key = [&] { return Device(info, quick()).state().cacheKey; }();
    const std::filesystem::path file = compile();
    ASSERT_EQ(file.parent_path(), folder / "raig");
    EXPECT_TRUE(vk::decodeCache(readFile(file), key).has_value());

    std::vector<std::byte> damaged = readFile(file);
    damaged.resize(damaged.size() - 1);
    writeFileAtomically(file, damaged);
    compile();
    EXPECT_TRUE(vk::decodeCache(readFile(file), key).has_value());

    std::filesystem::remove_all(folder / "raig");
    writeFileAtomically(folder / "raig", std::span<const std::byte>());  // a file where the folder should be
    compile();
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "raig"));
    std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(Devices, OnEveryDevice, testing::ValuesIn(devicesToTest()), testName);
INSTANTIATE_TEST_SUITE_P(Devices, Refusals, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig

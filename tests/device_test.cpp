// Devices and their memory: what was put in comes back, what is too much is refused, and validation is silent.
#include "base/error.hpp"
#include "device/commands.hpp"
#include "support/devices.hpp"
#include "support/program.hpp"
#include "support/selftest.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace raig {
namespace {

using namespace test;

/// The exit code and text of the Error that `body` throws; done and nothing if it throws none.
template <class Body>
std::pair<ExitCode, std::string> errorOf(const Body& body) {
    try {
        body();
    } catch (const Error& error) {
        return {error.exitCode, error.what()};
    }
    return {ExitCode::done, ""};
}

// ---- Choosing ------------------------------------------------------------------------------------------------------------

TEST(DeviceChoice, CpuIsNoDevice) {
    EXPECT_FALSE(chooseDevice("cpu").has_value());
    EXPECT_FALSE(chooseDevice("CPU").has_value());
}

TEST(DeviceChoice, AutoIsTheFirstListedOrTheCpu) {
    const auto chosen = chooseDevice("auto");
    ASSERT_EQ(chosen.has_value(), !listDevices().empty());
    EXPECT_EQ(chosen ? chosen->index : 0u, 0u);
}

TEST(DeviceChoice, DevicesAreListedBestFirstUnderTheirIndex) {
    const std::vector<DeviceInfo>& devices = listDevices();
    for (size_t i = 0; i < devices.size(); ++i) {
        EXPECT_EQ(devices[i].index, i);
        EXPECT_LE(devices[i > 0 ? i - 1 : 0].type, devices[i].type);
    }
}

TEST(DeviceChoice, UnknownNamesAndIndicesAreAnErrorThatListsTheDevices) {
    for (const char* wanted : {"no such device", "4711", "-1", "", "0x0"}) {
        const auto [code, text] = errorOf([&] { chooseDevice(wanted); });
        EXPECT_EQ(code, ExitCode::noDevice) << wanted;
        EXPECT_NE(text.find("cpu"), std::string::npos) << text;
        for (const DeviceInfo& device : listDevices()) EXPECT_NE(text.find(device.name), std::string::npos) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos);
    }
}

TEST(DeviceChoice, SettingsForTheLoaderAreTakenBack) {
    listDevices();  // as happened before, to name the tests; children of this process would inherit what stayed
    const ProgramResult result = runProgram("/usr/bin/env", {});
    for (const char* name : {"VK_ADD_DRIVER_FILES=/usr", "NODEVICE_SELECT="})
        EXPECT_EQ(result.output.find(name), std::string::npos) << name;
}

TEST(DeviceChoice, WithoutDriversThereIsOnlyTheCpu) {
    for (const char* setting : {"VK_DRIVER_FILES=/nonexistent.json", "VK_ICD_FILENAMES=/nonexistent.json"}) {
        const ProgramResult result = runProgram("/usr/bin/env", {"-u", "RAIG_VALIDATION", setting, RAIG_PROGRAM, "devices"});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        EXPECT_TRUE(result.output.starts_with("cpu")) << result.output;
    }
}

TEST(DeviceChoice, ListingPrintsNothingOnStandardError) {
    const ProgramResult result = runProgram("/usr/bin/env", {"-u", "RAIG_VALIDATION", RAIG_PROGRAM, "devices", "--json"});
    EXPECT_EQ(result.exitCode, 0);
    EXPECT_EQ(result.errors, "");
}

TEST(Validation, IsActiveInTheseTests) {
    if (listDevices().empty()) GTEST_SKIP() << "no Vulkan device here";
    if (!validationActive())
        GTEST_SKIP() << "VK_LAYER_KHRONOS_validation is not installed: mistakes in the use of Vulkan go unseen";
    EXPECT_TRUE(validationMessages().empty());
}

// ---- Devices -------------------------------------------------------------------------------------------------------------

TEST_P(OnEveryDevice, IsChosenByIndexAndByAPartOfItsNameInAnyCase) {
    EXPECT_EQ(chooseDevice(std::to_string(info.index))->name, info.name);
    std::string upper = GetParam();
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    EXPECT_EQ(chooseDevice(upper)->index, info.index);
}

TEST_P(OnEveryDevice, BuffersGiveBackWhatWasPutIn) {
    for (const bool staged : {false, true}) {
        Device device(info, quick({.stagesTransfers = staged}));
        const size_t size = (size_t{33} << 20) + 4;  // of three pieces through the staging buffer
        Buffer buffer(device, size);
        std::vector<std::byte> bytes = someBytes(size);
        buffer.upload(bytes);
        const std::vector<std::byte> patch = someBytes(40, 7);
        buffer.upload(patch, (size_t{16} << 20) - 20);
        std::copy(patch.begin(), patch.end(), bytes.begin() + (16 << 20) - 20);
        EXPECT_TRUE(buffer.downloadValues<std::byte>() == bytes) << "staged " << staged;
        std::vector<std::byte> part(60);
        buffer.download(part, size - 60);
        EXPECT_TRUE(std::equal(part.begin(), part.end(), bytes.end() - 60)) << "staged " << staged;
    }
}

TEST_P(OnEveryDevice, FillsSetEveryWordAndNoOther) {
    for (const bool staged : {false, true}) {
        Device device(info, quick({.stagesTransfers = staged}));
        Buffer buffer(device, 4096);
        buffer.fill(0xdeadbeefu);
        std::vector<uint32_t> want(1024, 0xdeadbeefu);
        EXPECT_EQ(buffer.downloadValues<uint32_t>(), want);
        Commands commands(device);
        commands.fill(buffer, 7, 400, 40);
        commands.run();
        std::fill_n(want.begin() + 100, 10, 7u);
        EXPECT_EQ(buffer.downloadValues<uint32_t>(), want);
        commands.fill(buffer, 9);
        commands.run();
        EXPECT_EQ(buffer.downloadValues<uint32_t>(), std::vector<uint32_t>(1024, 9u));
    }
}

/// Reads all elements of an array of `bytes` through kernel selftest_load.
std::vector<std::byte> readBack(Device& device, const std::vector<std::byte>& bytes, uint32_t expectedChunks) {
    const BigArray array(device, bytes);
    EXPECT_EQ(array.chunkCount(), expectedChunks) << bytes.size();
    const auto count = static_cast<uint32_t>(array.elements());
    Kernel kernel(device, "selftest_load", loadKernel(device.loadsTexel()),
                  {{/* local size */ 0, 64}, {/* CHUNKS */ 1, array.chunkCount()}, {/* SHIFT */ 2, array.chunkShift()}});
    Buffer copies(device, uint64_t{count} * 16);
    kernel.bind(0, array);
    kernel.bind(1, copies);
    Commands commands(device);
    commands.dispatch(kernel, {(count + 63) / 64}, LoadPush{0, count});
    commands.run();
    return copies.downloadValues<std::byte>();
}

TEST_P(OnEveryDevice, BigArraysReadBackAcrossTheirChunks) {
    for (const bool texel : {false, true})
        for (const bool staged : {false, true}) {
            Device device(info, quick({.loadsTexel = texel, .largestBindingElements = 1000, .stagesTransfers = staged}));
            EXPECT_EQ(BigArray::capacity(device), 16u * 4 * 512);
            const std::pair<size_t, uint32_t> sizes[] = {{0, 1},         {1, 1},
                                                         {16, 1},        {1000 * 16, 1},
                                                         {1001 * 16, 2}, {1024 * 16, 2},
                                                         {1025 * 16, 3}, {1536 * 16 - 3, 3},
                                                         {2048 * 16, 4}, {2047 * 16 + 1, 4}};
            for (const auto& [size, chunks] : sizes) {
                std::vector<std::byte> bytes = someBytes(size);
                const std::vector<std::byte> got = readBack(device, bytes, chunks);
                bytes.resize(std::max<size_t>(16, (size + 15) / 16 * 16));  // padded with zeros
                EXPECT_TRUE(got == bytes) << size << " bytes, texel " << texel << ", staged " << staged;
            }
        }
}

TEST_P(OnEveryDevice, BigArraysBeyondTheirBindingsAreRefusedWithTheirSizeAndTheLimit) {
    for (const bool texel : {false, true}) {
        Device device(info, quick({.loadsTexel = texel, .largestBindingElements = 1000}));
        const auto [code, text] = errorOf([&] { BigArray(device, someBytes(2048 * 16 + 1)); });
        EXPECT_EQ(code, ExitCode::limit);
        EXPECT_NE(text.find("32769"), std::string::npos) << text;
        EXPECT_NE(text.find("32768"), std::string::npos) << text;
    }
}

TEST_P(OnEveryDevice, BuffersBeyondTheDevicesLimitAreRefused) {
    Device device(info, quick());
    for (const uint64_t bytes : {info.limits.storageBufferBytes + 1, info.limits.allocationBytes + 1, uint64_t{1} << 62}) {
        const auto [code, text] = errorOf([&] { Buffer(device, bytes); });
        EXPECT_EQ(code, ExitCode::limit) << bytes;
        EXPECT_NE(text.find(std::to_string(bytes)), std::string::npos) << text;
    }
}

// Each dispatch reads the results of the one before as its operands: without barriers this is a race.
TEST_P(OnEveryDevice, DispatchesSeeWhatEarlierOnesWrote) {
    Device device(info, quick());
    Kernel kernel(device, "selftest", findKernel("selftest_storage").value());
    const struct Push { uint32_t count; } push{64};
    const auto chain = [&](bool together) {
        std::vector<Buffer> buffers;
        for (int i = 0; i < 6; ++i) {
            buffers.emplace_back(device, 64 * 64);
            buffers.back().fill(0);
        }
        buffers[0].upload(someBytes(64 * 64));
        Commands commands(device);
        for (size_t i = 1; i < buffers.size(); ++i) {
            kernel.bind(0, buffers[i - 1]);
            kernel.bind(1, buffers[i]);
            commands.dispatch(kernel, {1}, push);
            if (!together) commands.run();
        }
        commands.run();
        return buffers.back().downloadValues<uint32_t>();
    };
    const std::vector<uint32_t> want = chain(/* together= */ false);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(chain(/* together= */ true), want);
}

TEST_P(OnEveryDevice, ARecordingHoldsAThousandDispatchesWithTheirOwnBindings) {
    Device device(info, quick());
    std::vector<uint32_t> words(4000);
    std::iota(words.begin(), words.end(), 0u);
    const BigArray array(device, std::as_bytes(std::span(words)));
    Kernel kernel(device, "selftest_load", loadKernel(device.loadsTexel()), {{0, 1}});
    kernel.bind(0, array);
    std::vector<Buffer> copies;
    Commands commands(device);
    for (int round = 0; round < 2; ++round) {
        copies.clear();
        for (uint32_t i = 0; i < 1000; ++i) {
            kernel.bind(1, copies.emplace_back(device, 16));
            commands.dispatch(kernel, {1}, LoadPush{i, 1});
        }
        const RunReport report = commands.run();
        EXPECT_GT(report.seconds, 0.0);
        EXPECT_EQ(report.deviceSeconds > 0.0, info.features.timestamps);
        for (uint32_t i = 0; i < 1000; ++i)
            ASSERT_EQ(copies[i].downloadValues<uint32_t>(), std::vector<uint32_t>(&words[4 * i], &words[4 * i] + 4));
    }
}

TEST_P(OnEveryDevice, NothingRecordedIsNothingRun) {
    Device device(info, quick());
    Commands commands(device);
    EXPECT_EQ(commands.run().deviceSeconds, 0.0);
    Kernel kernel(device, "selftest", findKernel("selftest_storage").value());
    const struct Push { uint32_t count; } push{0};
    commands.dispatch(kernel, {0, 1, 1}, push);  // no groups: its bindings are not looked at
    EXPECT_EQ(commands.run().deviceSeconds, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Devices, OnEveryDevice, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig

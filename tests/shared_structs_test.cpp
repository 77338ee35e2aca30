// The structs that are written once and compiled twice lie in memory alike on both sides, member by member.
#include "device/commands.hpp"
#include "rays/frame_types.hpp"
#include "rays/item_view.hpp"
#include "rays/kernels.hpp"
#include "structures/structure.hpp"
#include "support/devices.hpp"

#include <array>
#include <bit>
#include <cstring>

namespace raig::shared {

/// The members' words, as C++ finds them.
struct Members {
    std::vector<uint32_t> words;
    void put(uint x) { words.push_back(x); }
    void put(float x) { words.push_back(std::bit_cast<uint32_t>(x)); }
    void put(const vec3& v) { put(v.x), put(v.y), put(v.z); }
    void put(const vec4& v) { put(v.x), put(v.y), put(v.z), put(v.w); }

#include "members.glsl"
};

}  // namespace raig::shared

namespace raig {
namespace {

using namespace shared;

/// A struct whose every word is another normal float.
template <class T>
T numbered(uint32_t first) {
    std::array<uint32_t, sizeof(T) / 4> words;
    for (uint32_t i = 0; i < words.size(); ++i) words[i] = 0x3f800000u + first + i;
    return std::bit_cast<T>(words);
}

template <class T>
void expectEveryWordNamed() {
    Members members;
    members.putAll(numbered<T>(0));
    ASSERT_EQ(members.words.size(), sizeof(T) / 4) << "a member is missing, or there is padding";
    for (uint32_t i = 0; i < members.words.size(); ++i) EXPECT_EQ(members.words[i], 0x3f800000u + i);
}

TEST(SharedStructsInMemory, HaveNoPaddingAndNoUnnamedMembers) {
    expectEveryWordNamed<Ray>();
    expectEveryWordNamed<Hit>();
    expectEveryWordNamed<StructureHeader>();
    expectEveryWordNamed<FrameParams>();
    expectEveryWordNamed<TileStep>();
    expectEveryWordNamed<PathState>();
    expectEveryWordNamed<PendingRay>();
    expectEveryWordNamed<PixelResult>();
    expectEveryWordNamed<PrimaryHit>();
    expectEveryWordNamed<ItemView>();
    expectEveryWordNamed<ItemCall>();
    expectEveryWordNamed<ItemWindow>();
}

/// One struct on its way to the device: a buffer of two, the first filled.
template <class T>
struct Sent {
    Sent(Device& device, uint32_t first, Members& expected) : value(numbered<T>(first)), buffer(device, 2 * sizeof(T)) {
        buffer.fill(0);
        buffer.uploadValues(std::span<const T>(&value, 1));
        expected.putAll(value);
    }
    void expectTheSecondEqual() const {
        std::array<T, 2> back;
        buffer.download(std::as_writable_bytes(std::span(back)));
        EXPECT_EQ(std::memcmp(&back[1], &value, sizeof(T)), 0) << "a struct of " << sizeof(T) << " bytes";
    }
    T value;
    Buffer buffer;
};

class SharedStructs : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, SharedStructs, testing::ValuesIn(devicesToTest()), testName);

TEST_P(SharedStructs, GoToTheDeviceAndBackMemberByMember) {
    Device device(info);
    Members expected;
    const Sent<Ray> ray(device, 100, expected);
    const Sent<Hit> hit(device, 200, expected);
    const Sent<StructureHeader> header(device, 300, expected);
    const Sent<FrameParams> params(device, 400, expected);
    const Sent<TileStep> step(device, 500, expected);
    const Sent<PathState> state(device, 600, expected);
    const Sent<PendingRay> pending(device, 700, expected);
    const Sent<PixelResult> result(device, 800, expected);
    const Sent<PrimaryHit> primary(device, 900, expected);
    const Sent<ItemView> view(device, 1100, expected);
    const Sent<ItemCall> call(device, 1200, expected);
    const Sent<ItemWindow> window(device, 1300, expected);
    const TileStep pushed = numbered<TileStep>(1000);
    expected.putAll(pushed);

    Buffer words(device, expected.words.size() * 4);
    words.fill(0);
    Kernel kernel(device, "members", findKernel("members_storage").value());
    kernel.bind(0, words);
    const Buffer* buffers[] = {&ray.buffer,  &hit.buffer,   &header.buffer,  &params.buffer,
                               &step.buffer, &state.buffer, &pending.buffer, &result.buffer,
                               &primary.buffer, &view.buffer, &call.buffer, &window.buffer};
    for (uint32_t i = 0; i < std::size(buffers); ++i) kernel.bind(i + 1, *buffers[i]);
    Commands commands(device);
    commands.dispatch(kernel, {}, pushed);
    commands.run();

    EXPECT_EQ(words.downloadValues<uint32_t>(), expected.words);
    ray.expectTheSecondEqual();
    hit.expectTheSecondEqual();
    header.expectTheSecondEqual();
    params.expectTheSecondEqual();
    step.expectTheSecondEqual();
    state.expectTheSecondEqual();
    pending.expectTheSecondEqual();
    result.expectTheSecondEqual();
    primary.expectTheSecondEqual();
    view.expectTheSecondEqual();
    call.expectTheSecondEqual();
    window.expectTheSecondEqual();
}

}  // namespace
}  // namespace raig

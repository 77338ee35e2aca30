#include "device/buffer.hpp"

#include "device/vulkan.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace raig {

namespace {

constexpr uint64_t stagingBytes = uint64_t{16} << 20;
constexpr VkBufferUsageFlags copyUsage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

/// The first type allowed by `allowed` that has all of the first set of properties that any has: drivers list better ones
/// first.
std::optional<uint32_t> findMemoryType(const VkPhysicalDeviceMemoryProperties& memory, uint32_t allowed,
                                       std::initializer_list<VkMemoryPropertyFlags> preferences) {
    for (const VkMemoryPropertyFlags wanted : preferences)
        for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
            if ((allowed >> i & 1u) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    return std::nullopt;
}

std::optional<uint32_t> chooseMemoryType(const Device::State& device, uint32_t allowed, vk::Memory kind) {
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags cached = host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    const VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    if (kind == vk::Memory::staging) return findMemoryType(device.memory, allowed, {cached, host});
    if (device.staged) return findMemoryType(device.memory, allowed, {local, 0});
    return findMemoryType(device.memory, allowed, {local | cached, cached});
}

/// The staging buffer and what copies through it, made when first needed.
void needStaging(Device::State& device) {
    if (device.staging == nullptr) device.staging = vk::makeBuffer(device, stagingBytes, copyUsage, vk::Memory::staging);
    if (device.transfers == nullptr) device.transfers = std::make_unique<vk::Recorder>(device);
}

void copy(Device::State& device, VkBuffer from, VkBuffer to, const VkBufferCopy& region) {
    vk::Recorder& recorder = *device.transfers;
    recorder.begin();
    vk::barrier(device.call, recorder.commands);
    device.call.vkCmdCopyBuffer(recorder.commands, from, to, 1, &region);
    vk::barrierToHost(device.call, recorder.commands);
    recorder.submit();
    recorder.wait();
}

/// Calls body(done, piece size) until `bytes` are done, in pieces that fit the staging buffer.
template <class Body>
void inPieces(uint64_t bytes, const Body& body) {
    for (uint64_t done = 0; done < bytes; done += stagingBytes) body(done, std::min(stagingBytes, bytes - done));
}

void checkRange(const vk::BufferState& state, uint64_t offset, uint64_t bytes) {
    RAIG_CHECK_OP(offset, <=, state.bytes);
    RAIG_CHECK_OP(bytes, <=, state.bytes - offset);
    RAIG_CHECK_OP(offset % 4, ==, 0u);
    RAIG_CHECK_OP(bytes % 4, ==, 0u);
}

void makeTexelView(vk::BufferState& state) {
    VkBufferViewCreateInfo create = vk::init<VkBufferViewCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO);
    create.buffer = state.buffer;
    create.format = VK_FORMAT_R32G32B32A32_UINT;  // one that every device has for texel buffers
    create.range = state.bytes;
    vk::check(state.device->call.vkCreateBufferView(state.device->handle, &create, nullptr, &state.view),
              "read a buffer as texels");
}

}  // namespace

namespace vk {

BufferState::~BufferState() {
    if (device == nullptr) return;
    device->call.vkDestroyBufferView(device->handle, view, nullptr);
    device->call.vkDestroyBuffer(device->handle, buffer, nullptr);
    device->call.vkFreeMemory(device->handle, memory, nullptr);
}

std::shared_ptr<BufferState> makeBuffer(Device::State& device, uint64_t bytes, VkBufferUsageFlags usage, Memory kind) {
    RAIG_CHECK_OP(bytes, >, 0u);
    const bool hasAddress = device.options.rayQuery && kind == Memory::device;
    if (hasAddress)
        usage |= VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    const auto state = std::make_shared<BufferState>();
    state->device = &device;
    state->bytes = bytes;
    state->storage = (usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) != 0;
    const auto tooLarge = [&](uint64_t limit, const char* of) {
        return limitError("device '{}': a buffer of {} bytes exceeds its limit of {} a {}; a smaller scene or batch may fit",
                          device.info.name, bytes, limit, of);
    };
    if (bytes > device.info.limits.allocationBytes) throw tooLarge(device.info.limits.allocationBytes, "piece of memory");
    if (state->storage && bytes > device.info.limits.storageBufferBytes)
        throw tooLarge(device.info.limits.storageBufferBytes, "storage buffer");

    VkBufferCreateInfo create = vk::init<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    create.size = bytes;
    create.usage = usage;
    check(device.call.vkCreateBuffer(device.handle, &create, nullptr, &state->buffer), "make a buffer");
    VkMemoryRequirements needs{};
    device.call.vkGetBufferMemoryRequirements(device.handle, state->buffer, &needs);
    const std::optional<uint32_t> type = chooseMemoryType(device, needs.memoryTypeBits, kind);
    if (!type) throw deviceError("device '{}' has no memory fit for buffers; --device names another", device.info.name);

    VkMemoryAllocateInfo allocate = vk::init<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = *type;
    VkMemoryAllocateFlagsInfo flags = vk::init<VkMemoryAllocateFlagsInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    if (hasAddress) allocate.pNext = &flags;
    const VkResult result = device.call.vkAllocateMemory(device.handle, &allocate, nullptr, &state->memory);
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY)
        throw limitError("device '{}' has no memory left for a buffer of {} bytes; a smaller scene or picture may fit",
                         device.info.name, bytes);
    check(result, "allocate memory");
    check(device.call.vkBindBufferMemory(device.handle, state->buffer, state->memory, 0), "give a buffer its memory");
    if (kind == Memory::staging || !device.staged) {
        void* mapped = nullptr;
        check(device.call.vkMapMemory(device.handle, state->memory, 0, VK_WHOLE_SIZE, 0, &mapped), "map memory");
        state->mapped = static_cast<std::byte*>(mapped);
    }
    return state;
}

}  // namespace vk

Buffer::Buffer(Device& device, uint64_t bytes) {
    const bool texel = device.loadsTexel() && bytes % 16 == 0 && bytes / 16 <= device.info().limits.texelBufferElements;
    const VkBufferUsageFlags alsoTexel = texel ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT : 0;
    state_ = vk::makeBuffer(device.state(), bytes, alsoTexel | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | copyUsage,
                            vk::Memory::device);
    if (texel) makeTexelView(*state_);
}

Buffer::Buffer(Device& device, uint64_t bytes, bool texel) {
    // Beside its texels a chunk can serve as storage too, if it is small enough for that.
    const bool storage = !texel || bytes <= device.info().limits.storageBufferBytes;
    state_ = vk::makeBuffer(device.state(), bytes,
                            (texel ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT : 0) |
                                (storage ? VK_BUFFER_USAGE_STORAGE_BUFFER_BIT : 0) | copyUsage,
                            vk::Memory::device);
    if (texel) makeTexelView(*state_);
}

uint64_t Buffer::bytes() const {
    return state_->bytes;
}

void Buffer::upload(std::span<const std::byte> data, uint64_t offset) {
    checkRange(*state_, offset, data.size());
    if (data.empty()) return;
    if (state_->mapped) {
        std::memcpy(state_->mapped + offset, data.data(), data.size());
        return;
    }
    Device::State& device = *state_->device;
    needStaging(device);
    inPieces(data.size(), [&](uint64_t done, uint64_t piece) {
        std::memcpy(device.staging->mapped, data.data() + done, piece);
        copy(device, device.staging->buffer, state_->buffer, {0, offset + done, piece});
    });
}

void Buffer::download(std::span<std::byte> data, uint64_t offset) const {
    checkRange(*state_, offset, data.size());
    if (data.empty()) return;
    if (state_->mapped) {
        std::memcpy(data.data(), state_->mapped + offset, data.size());
        return;
    }
    Device::State& device = *state_->device;
    needStaging(device);
    inPieces(data.size(), [&](uint64_t done, uint64_t piece) {
        copy(device, state_->buffer, device.staging->buffer, {offset + done, 0, piece});
        std::memcpy(data.data() + done, device.staging->mapped, piece);
    });
}

void Buffer::fill(uint32_t word) {
    checkRange(*state_, 0, state_->bytes);
    if (state_->mapped) {
        auto* words = reinterpret_cast<uint32_t*>(state_->mapped);  // mapped memory is aligned to 64 bytes at least
        std::fill_n(words, state_->bytes / 4, word);
        return;
    }
    Device::State& device = *state_->device;
    needStaging(device);
    device.transfers->begin();
    vk::barrier(device.call, device.transfers->commands);
    device.call.vkCmdFillBuffer(device.transfers->commands, state_->buffer, 0, VK_WHOLE_SIZE, word);
    device.transfers->submit();
    device.transfers->wait();
}

BigArray::BigArray(Device& device, std::span<const std::byte> data) {
    elements_ = std::max<uint64_t>(1, data.size() / 16 + (data.size() % 16 != 0));
    const uint64_t binding = device.largestBindingElements();
    if (data.size() > capacity(device))
        throw limitError(
            "device '{}': an array of {} bytes exceeds its limit of {}, {} bindings; a smaller scene may fit, and "
            "--device cpu has no such limit",
            device.info().name, data.size(), capacity(device), maxChunks);
    if (elements_ > binding) shift_ = static_cast<uint32_t>(std::bit_width(binding) - 1);

    for (uint64_t done = 0; done < elements_;) {
        const uint64_t count = std::min(elements_ - done, uint64_t{1} << shift_);
        Buffer& chunk = chunks_.emplace_back(Buffer(device, count * 16, device.loadsTexel()));
        const uint64_t whole = std::min<uint64_t>(count * 16, data.size() - done * 16) / 4 * 4;
        chunk.upload(data.subspan(done * 16, whole));
        if (whole < count * 16) {  // the last element, padded
            std::array<std::byte, 16> last{};
            const uint64_t start = (count - 1) * 16;
            const std::span<const std::byte> rest = data.subspan(done * 16 + start);
            std::copy(rest.begin(), rest.end(), last.begin());
            chunk.upload(last, start);
        }
        done += count;
    }
}

uint64_t BigArray::capacity(const Device& device) {
    const uint64_t binding = device.largestBindingElements();
    // Split evenly by a shift, or all in one.
    return 16 * std::max(binding, std::bit_floor(binding) * maxChunks);
}

}  // namespace raig

#include "device/commands.hpp"

#include "base/log.hpp"
#include "device/vulkan.hpp"

#include <algorithm>
#include <chrono>

namespace raig {

namespace vk {

namespace {

void memoryBarrier(const VolkDeviceTable& call, VkCommandBuffer commands, VkPipelineStageFlags before, VkAccessFlags written,
                   VkPipelineStageFlags after, VkAccessFlags used) {
    VkMemoryBarrier memory = vk::init<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    memory.srcAccessMask = written;
    memory.dstAccessMask = used;
    call.vkCmdPipelineBarrier(commands, before, after, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

constexpr VkPipelineStageFlags workStages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
constexpr VkAccessFlags writes = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;

}  // namespace

void barrier(const VolkDeviceTable& call, VkCommandBuffer commands) {
    memoryBarrier(call, commands, workStages, writes, workStages,
                  writes | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT);
}

void barrierToHost(const VolkDeviceTable& call, VkCommandBuffer commands) {
    memoryBarrier(call, commands, workStages, writes, VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

void waitFor(Device::State& device, VkFence fence) {
    const uint64_t slice = 1'000'000'000;  // in slices, so that a lost device is noticed and a busy one reported
    for (int seconds = 1;; ++seconds) {
        const VkResult result = device.call.vkWaitForFences(device.handle, 1, &fence, VK_TRUE, slice);
        if (result != VK_TIMEOUT) return check(result, "finish its work");
        if (seconds == 60) log::warn("device '{}' has been busy with one piece of work for a minute", device.info.name);
    }
}

Recorder::Recorder(Device::State& state) : device(state) {
    VkCommandBufferAllocateInfo allocate =
        vk::init<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    allocate.commandPool = device.commandPool;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(device.call.vkAllocateCommandBuffers(device.handle, &allocate, &commands), "record commands");
    const VkFenceCreateInfo create = vk::init<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
    check(device.call.vkCreateFence(device.handle, &create, nullptr, &fence), "make a fence");
}

Recorder::~Recorder() {
    device.call.vkDestroyFence(device.handle, fence, nullptr);
    device.call.vkFreeCommandBuffers(device.handle, device.commandPool, 1, &commands);
}

void Recorder::begin() {
    VkCommandBufferBeginInfo begin = vk::init<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(device.call.vkBeginCommandBuffer(commands, &begin), "record commands");
}

void Recorder::submit() {
    check(device.call.vkEndCommandBuffer(commands), "record commands");
    VkSubmitInfo submission = vk::init<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    submission.commandBufferCount = 1;
    submission.pCommandBuffers = &commands;
    check(device.call.vkQueueSubmit(device.queue, 1, &submission, fence), "start its work");
}

void Recorder::wait() {
    waitFor(device, fence);
    check(device.call.vkResetFences(device.handle, 1, &fence), "reset a fence");
}

}  // namespace vk

namespace {

/// Descriptor sets for one recording; all are given back together.
class DescriptorPools {
public:
    explicit DescriptorPools(Device::State& device) : device_(device) {}
    ~DescriptorPools() {
        for (const Pool& pool : pools_) device_.call.vkDestroyDescriptorPool(device_.handle, pool.handle, nullptr);
    }
    DescriptorPools(const DescriptorPools&) = delete;
    DescriptorPools& operator=(const DescriptorPools&) = delete;

    /// A pool with room for a set of `kernel` is counted by us: drivers need not say when one is full.
    VkDescriptorSet allocate(const Kernel::State& kernel) {
        while (current_ < pools_.size() && !pools_[current_].take(kernel)) ++current_;
        if (current_ == pools_.size()) {
            pools_.push_back(makePool(kernel));
            RAIG_CHECK(pools_.back().take(kernel));
        }
        VkDescriptorSetAllocateInfo allocate =
            vk::init<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
        allocate.descriptorPool = pools_[current_].handle;
        allocate.descriptorSetCount = 1;
        allocate.pSetLayouts = &kernel.setLayout;
        VkDescriptorSet set = VK_NULL_HANDLE;
        vk::check(device_.call.vkAllocateDescriptorSets(device_.handle, &allocate, &set), "bind buffers");
        return set;
    }

    void reset() {
        for (Pool& pool : pools_) {
            vk::check(device_.call.vkResetDescriptorPool(device_.handle, pool.handle, 0), "bind buffers");
            pool.left = pool.room;
        }
        current_ = 0;
    }

private:
    struct Room {
        uint32_t sets, storage, texel;
    };
    struct Pool {
        VkDescriptorPool handle;
        Room room, left;
        bool take(const Kernel::State& kernel) {
            if (left.sets < 1 || left.storage < kernel.storageDescriptors || left.texel < kernel.texelDescriptors)
                return false;
            left = {left.sets - 1, left.storage - kernel.storageDescriptors, left.texel - kernel.texelDescriptors};
            return true;
        }
    };

    Pool makePool(const Kernel::State& kernel) const {
        const uint32_t sets = 64;
        const Room room{sets, std::max(sets * 8, kernel.storageDescriptors), std::max(sets * 8, kernel.texelDescriptors)};
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, room.storage},
                                              {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, room.texel}};
        VkDescriptorPoolCreateInfo create =
            vk::init<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
        create.maxSets = sets;
        create.poolSizeCount = 2;
        create.pPoolSizes = sizes;
        Pool pool{VK_NULL_HANDLE, room, room};
        vk::check(device_.call.vkCreateDescriptorPool(device_.handle, &create, nullptr, &pool.handle), "bind buffers");
        return pool;
    }

    Device::State& device_;
    std::vector<Pool> pools_;
    size_t current_ = 0;
};

}  // namespace

struct Commands::State {
    explicit State(Device::State& state) : device(state), recorder(state), pools(state) {
        if (device.info.limits.timestampNanoseconds <= 0.0) return;
        VkQueryPoolCreateInfo create = vk::init<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
        create.queryType = VK_QUERY_TYPE_TIMESTAMP;
        create.queryCount = 2;
        vk::check(device.call.vkCreateQueryPool(device.handle, &create, nullptr, &clock), "measure time");
    }
    ~State() {
        if (submitted) device.call.vkDeviceWaitIdle(device.handle);
        device.call.vkDestroyQueryPool(device.handle, clock, nullptr);
    }

    /// Starts a recording with the first command, and orders a command behind those before it.
    void next() {
        RAIG_CHECK(!submitted);
        if (!recording) {
            recorder.begin();
            recording = true;
            if (clock != VK_NULL_HANDLE) {
                device.call.vkCmdResetQueryPool(recorder.commands, clock, 0, 2);
                device.call.vkCmdWriteTimestamp(recorder.commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, clock, 0);
            }
        }
        vk::barrier(device.call, recorder.commands);
    }

    void bindBuffers(const Kernel::State& kernel);
    double deviceSeconds() const;

    Device::State& device;
    vk::Recorder recorder;
    DescriptorPools pools;
    VkQueryPool clock = VK_NULL_HANDLE;
    bool recording = false;
    bool submitted = false;
    std::chrono::steady_clock::time_point start;
    std::vector<std::shared_ptr<vk::BufferState>> inUse;  ///< of the present recording
};

void Commands::State::bindBuffers(const Kernel::State& kernel) {
    const VkDescriptorSet set = pools.allocate(kernel);
    std::vector<VkDescriptorBufferInfo> buffers;
    std::vector<VkBufferView> views;
    buffers.reserve(kernel.storageDescriptors);  // written to by address: they must not move
    views.reserve(kernel.texelDescriptors);
    std::vector<VkWriteDescriptorSet> updates;
    for (const auto& [number, binding] : kernel.interface.bindings) {
        const auto found = kernel.bound.find(number);
        if (found == kernel.bound.end()) {
            if (binding.used)
                checkFailed(__FILE__, __LINE__,
                            fmt::format("kernel {}: binding {} ({}) is bound", kernel.name, number, binding.name));
            continue;
        }
        const bool texel = binding.kind == KernelBinding::Kind::texel;
        VkWriteDescriptorSet update = vk::init<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
        update.dstSet = set;
        update.dstBinding = number;
        update.descriptorCount = binding.count;
        update.descriptorType = texel ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        update.pBufferInfo = buffers.data() + buffers.size();
        update.pTexelBufferView = views.data() + views.size();
        for (const std::weak_ptr<vk::BufferState>& bound : found->second.buffers) {
            const std::shared_ptr<vk::BufferState>& buffer = inUse.emplace_back(bound.lock());
            if (buffer == nullptr)
                checkFailed(__FILE__, __LINE__,
                            fmt::format("kernel {}: the buffer of binding {} exists", kernel.name, number));
            if (texel)
                views.push_back(buffer->view);
            else
                buffers.push_back({buffer->buffer, 0, buffer->bytes});
        }
        updates.push_back(update);
    }
    device.call.vkUpdateDescriptorSets(device.handle, static_cast<uint32_t>(updates.size()), updates.data(), 0, nullptr);
    device.call.vkCmdBindDescriptorSets(recorder.commands, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.layout, 0, 1, &set, 0,
                                        nullptr);
}

double Commands::State::deviceSeconds() const {
    if (clock == VK_NULL_HANDLE) return 0.0;
    uint64_t ticks[2] = {};
    const VkResult result =
        device.call.vkGetQueryPoolResults(device.handle, clock, 0, 2, sizeof(ticks), ticks, sizeof(ticks[0]),
                                          VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    vk::check(result, "measure time");
    return ticks[1] > ticks[0] ? static_cast<double>(ticks[1] - ticks[0]) * device.info.limits.timestampNanoseconds * 1e-9
                               : 0.0;
}

Commands::Commands(Device& device) : state_(std::make_unique<State>(device.state())) {}
Commands::~Commands() = default;

void Commands::dispatch(const Kernel& kernel, Groups groups, std::span<const std::byte> push) {
    const Kernel::State& use = kernel.state();
    const auto& most = state_->device.info.limits.workgroupCount;
    RAIG_CHECK(use.device == &state_->device);
    RAIG_CHECK_OP(push.size(), ==, use.interface.pushBytes);
    RAIG_CHECK(groups.x <= most[0] && groups.y <= most[1] && groups.z <= most[2]);
    if (groups.x == 0 || groups.y == 0 || groups.z == 0) return;

    state_->next();
    const VolkDeviceTable& call = state_->device.call;
    const VkCommandBuffer commands = state_->recorder.commands;
    call.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, use.pipeline);
    state_->bindBuffers(use);
    if (!push.empty())
        call.vkCmdPushConstants(commands, use.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, static_cast<uint32_t>(push.size()),
                                push.data());
    call.vkCmdDispatch(commands, groups.x, groups.y, groups.z);
}

void Commands::fill(Buffer& buffer, uint32_t word, uint64_t offset, uint64_t bytes) {
    RAIG_CHECK_OP(offset, <=, buffer.bytes());
    if (bytes == 0) bytes = buffer.bytes() - offset;
    RAIG_CHECK_OP(bytes, <=, buffer.bytes() - offset);
    RAIG_CHECK(offset % 4 == 0 && bytes % 4 == 0);
    if (bytes == 0) return;
    state_->next();
    state_->inUse.push_back(buffer.state());
    state_->device.call.vkCmdFillBuffer(state_->recorder.commands, buffer.state()->buffer, offset, bytes, word);
}

void Commands::submit() {
    RAIG_CHECK(!state_->submitted);
    state_->start = std::chrono::steady_clock::now();
    if (!state_->recording) return;
    vk::barrierToHost(state_->device.call, state_->recorder.commands);
    if (state_->clock != VK_NULL_HANDLE)
        state_->device.call.vkCmdWriteTimestamp(state_->recorder.commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                                                state_->clock, 1);
    state_->recording = false;
    state_->recorder.submit();
    state_->submitted = true;
}

RunReport Commands::wait() {
    if (!state_->submitted) return {};
    state_->recorder.wait();
    state_->submitted = false;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - state_->start;
    const RunReport report{passed.count(), state_->deviceSeconds()};
    state_->pools.reset();
    state_->inUse.clear();
    return report;
}

RunReport Commands::run() {
    submit();
    return wait();
}

}  // namespace raig

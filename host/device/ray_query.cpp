#include "device/ray_query.hpp"

#include "device/vulkan.hpp"

#include <algorithm>
#include <chrono>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t workgroupSize = 128;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Push constants of shaders/ray_query.glsl.
struct Push {
    uint32_t first, end, anyHit;
};

VkDeviceAddress addressOf(const Device::State& device, const Buffer& buffer) {
    VkBufferDeviceAddressInfo info = vk::init<VkBufferDeviceAddressInfo>(VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO);
    info.buffer = buffer.state()->buffer;
    return device.call.vkGetBufferDeviceAddress(device.handle, &info);
}

/// An acceleration structure and the buffer it lies in.
struct Level {
    explicit Level(Device& device) : state(device.state()) {}
    ~Level() { state.call.vkDestroyAccelerationStructureKHR(state.handle, handle, nullptr); }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

    VkDeviceAddress address() const {
        VkAccelerationStructureDeviceAddressInfoKHR info = vk::init<VkAccelerationStructureDeviceAddressInfoKHR>(
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR);
        info.accelerationStructure = handle;
        return state.call.vkGetAccelerationStructureDeviceAddressKHR(state.handle, &info);
    }

    Device::State& state;
    std::optional<Buffer> buffer;
    VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
};

/// Builds a level over one geometry of `count` primitives.
void build(Device& device, Level& level, VkAccelerationStructureTypeKHR type, VkAccelerationStructureGeometryKHR geometry,
           uint32_t count) {
    Device::State& state = device.state();
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    VkAccelerationStructureBuildGeometryInfoKHR info = vk::init<VkAccelerationStructureBuildGeometryInfoKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR);
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    VkAccelerationStructureBuildSizesInfoKHR sizes =
        vk::init<VkAccelerationStructureBuildSizesInfoKHR>(VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR);
    state.call.vkGetAccelerationStructureBuildSizesKHR(state.handle, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                                       &count, &sizes);
    level.buffer.emplace(device, sizes.accelerationStructureSize);
    VkAccelerationStructureCreateInfoKHR create =
        vk::init<VkAccelerationStructureCreateInfoKHR>(VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR);
    create.buffer = level.buffer->state()->buffer;
    create.size = sizes.accelerationStructureSize;
    create.type = type;
    vk::check(state.call.vkCreateAccelerationStructureKHR(state.handle, &create, nullptr, &level.handle),
              "make an acceleration structure");

    constexpr uint64_t alignment = 256;  // the most that a device may ask of scratch memory
    const Buffer scratch(device, sizes.buildScratchSize + alignment);
    info.dstAccelerationStructure = level.handle;
    info.scratchData.deviceAddress = (addressOf(state, scratch) + alignment - 1) / alignment * alignment;
    const VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
    const VkAccelerationStructureBuildRangeInfoKHR* const ranges = &range;
    vk::Recorder recorder(state);
    recorder.begin();
    state.call.vkCmdBuildAccelerationStructuresKHR(recorder.commands, 1, &info, &ranges);
    VkMemoryBarrier memory = vk::init<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    memory.srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    memory.dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR;
    state.call.vkCmdPipelineBarrier(
        recorder.commands, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
        VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &memory, 0,
        nullptr, 0, nullptr);
    recorder.submit();
    recorder.wait();
}

VkAccelerationStructureGeometryKHR trianglesOf(const Device::State& device, const Buffer& positions, const Buffer& indices,
                                               size_t positionCount) {
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR& triangles = geometry.geometry.triangles;
    triangles = vk::init<VkAccelerationStructureGeometryTrianglesDataKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR);
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = addressOf(device, positions);
    triangles.vertexStride = sizeof(vec3);
    triangles.maxVertex = static_cast<uint32_t>(positionCount - 1);
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = addressOf(device, indices);
    return geometry;
}

VkAccelerationStructureGeometryKHR instancesOf(const Device::State& device, const Buffer& instances) {
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.geometry.instances = vk::init<VkAccelerationStructureGeometryInstancesDataKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR);
    geometry.geometry.instances.data.deviceAddress = addressOf(device, instances);
    return geometry;
}

template <class T>
Buffer bufferOf(Device& device, std::span<const T> values) {
    Buffer buffer(device, values.size_bytes());
    buffer.uploadValues(values);
    return buffer;
}

}  // namespace

struct RayQuery::State {
    explicit State(Device& opened) : device(opened.state()), bottom(opened), top(opened), recorder(opened.state()) {
        pipeline.device = &device;
    }
    ~State() {
        device.call.vkDestroyQueryPool(device.handle, clock, nullptr);
        device.call.vkDestroyDescriptorPool(device.handle, pool, nullptr);
    }

    void makePipeline(std::span<const uint32_t> spirv);
    void bind(const Buffer& rays, const Buffer& hits);
    RunReport dispatch(const Push& push);

    Device::State& device;
    Level bottom, top;
    vk::Recorder recorder;
    vk::Pipeline pipeline;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
    VkQueryPool clock = VK_NULL_HANDLE;  ///< none where the device has none
    uint32_t raysAtOnce = 4096;          ///< of a dispatch; learnt
};

void RayQuery::State::makePipeline(std::span<const uint32_t> spirv) {
    const VkDescriptorSetLayoutBinding bindings[] = {
        {0, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
        {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
        {2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
    auto setLayout = vk::init<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    setLayout.bindingCount = 3;
    setLayout.pBindings = bindings;
    const VkDevice handle = device.handle;
    vk::check(device.call.vkCreateDescriptorSetLayout(handle, &setLayout, nullptr, &pipeline.setLayout), "lay out a kernel");
    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(Push)};
    auto layout = vk::init<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &pipeline.setLayout;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    vk::check(device.call.vkCreatePipelineLayout(handle, &layout, nullptr, &pipeline.layout), "lay out a kernel");

    auto code = vk::init<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    code.codeSize = spirv.size_bytes();
    code.pCode = spirv.data();
    auto create = vk::init<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.pName = "main";
    create.layout = pipeline.layout;
    vk::check(device.call.vkCreateShaderModule(handle, &code, nullptr, &create.stage.module), "load a kernel");
    const VkResult result =
        device.call.vkCreateComputePipelines(handle, device.cache, 1, &create, nullptr, &pipeline.handle);
    device.call.vkDestroyShaderModule(handle, create.stage.module, nullptr);
    vk::check(result, "compile the kernel of ray queries");

    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2}};
    auto makePool = vk::init<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    makePool.maxSets = 1;
    makePool.poolSizeCount = 2;
    makePool.pPoolSizes = sizes;
    vk::check(device.call.vkCreateDescriptorPool(handle, &makePool, nullptr, &pool), "bind buffers");
    auto allocate = vk::init<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    allocate.descriptorPool = pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &pipeline.setLayout;
    vk::check(device.call.vkAllocateDescriptorSets(handle, &allocate, &set), "bind buffers");
    if (device.info.limits.timestampNanoseconds <= 0.0) return;
    auto makeClock = vk::init<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    makeClock.queryType = VK_QUERY_TYPE_TIMESTAMP;
    makeClock.queryCount = 2;
    vk::check(device.call.vkCreateQueryPool(handle, &makeClock, nullptr, &clock), "measure time");
}

void RayQuery::State::bind(const Buffer& rays, const Buffer& hits) {
    auto scene = vk::init<VkWriteDescriptorSetAccelerationStructureKHR>(
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR);
    scene.accelerationStructureCount = 1;
    scene.pAccelerationStructures = &top.handle;
    const VkDescriptorBufferInfo buffers[] = {{rays.state()->buffer, 0, VK_WHOLE_SIZE},
                                              {hits.state()->buffer, 0, VK_WHOLE_SIZE}};
    VkWriteDescriptorSet writes[3];
    for (uint32_t i = 0; i < 3; ++i) {
        writes[i] = vk::init<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
        writes[i].dstSet = set;
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType =
            i == 0 ? VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        if (i == 0)
            writes[i].pNext = &scene;
        else
            writes[i].pBufferInfo = &buffers[i - 1];
    }
    device.call.vkUpdateDescriptorSets(device.handle, 3, writes, 0, nullptr);
}

RunReport RayQuery::State::dispatch(const Push& push) {
    const Clock::time_point start = Clock::now();
    recorder.begin();
    const VkCommandBuffer commands = recorder.commands;
    if (clock) {
        device.call.vkCmdResetQueryPool(commands, clock, 0, 2);
        device.call.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, clock, 0);
    }
    device.call.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle);
    device.call.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0, 1, &set, 0, nullptr);
    device.call.vkCmdPushConstants(commands, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push), &push);
    device.call.vkCmdDispatch(commands, (push.end - push.first + workgroupSize - 1) / workgroupSize, 1, 1);
    if (clock) device.call.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, clock, 1);
    vk::barrierToHost(device.call, commands);
    recorder.submit();
    recorder.wait();
    RunReport report{secondsSince(start), 0.0};
    if (!clock) return report;
    uint64_t ticks[2] = {};
    vk::check(device.call.vkGetQueryPoolResults(device.handle, clock, 0, 2, sizeof(ticks), ticks, sizeof(ticks[0]),
                                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
              "measure time");
    if (ticks[1] > ticks[0])
        report.deviceSeconds = double(ticks[1] - ticks[0]) * device.info.limits.timestampNanoseconds * 1e-9;
    return report;
}

RayQuery::RayQuery(Device& device, std::span<const vec3> positions, std::span<const uvec3> triangles,
                   std::span<const uint32_t> spirv)
    : state_(std::make_unique<State>(device)) {
    RAIG_CHECK(device.state().options.rayQuery);
    RAIG_CHECK(!positions.empty() && !triangles.empty());
    State& state = *state_;
    const Buffer corners = bufferOf(device, positions), indices = bufferOf(device, triangles);
    build(device, state.bottom, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
          trianglesOf(state.device, corners, indices, positions.size()), static_cast<uint32_t>(triangles.size()));
    VkAccelerationStructureInstanceKHR instance{};
    for (int axis = 0; axis < 3; ++axis) instance.transform.matrix[axis][axis] = 1.0f;
    instance.mask = 0xff;
    instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    instance.accelerationStructureReference = state.bottom.address();
    const Buffer instances = bufferOf(device, std::span<const VkAccelerationStructureInstanceKHR>(&instance, 1));
    build(device, state.top, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, instancesOf(state.device, instances), 1);
    state.makePipeline(spirv);
}

RayQuery::~RayQuery() = default;

RunReport RayQuery::trace(const Buffer& rays, const Buffer& hits, uint32_t count, bool anyHit) {
    const double target = state_->device.info.type == DeviceType::software ? 0.25 : 0.02;
    state_->bind(rays, hits);
    RunReport sum;
    for (uint32_t first = 0; first < count;) {
        const uint32_t some = std::min(state_->raysAtOnce, count - first);
        const RunReport report = state_->dispatch({first, first + some, anyHit});
        sum.seconds += report.seconds;
        sum.deviceSeconds += report.deviceSeconds;
        first += some;
        if (some < state_->raysAtOnce && report.seconds < target) continue;  // a remainder tells little
        const double next = some * std::clamp(target / report.seconds, 0.0625, 8.0);
        state_->raysAtOnce = static_cast<uint32_t>(std::clamp(next, 256.0, 1048576.0));
    }
    return sum;
}

}  // namespace raig

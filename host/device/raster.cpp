#include "device/raster.hpp"

#include "device/raster_target.hpp"
#include "device/specialize.hpp"

#include <chrono>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

VkDescriptorType typeOf(const KernelBinding& binding) {
    return binding.kind == KernelBinding::Kind::texel ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
                                                      : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

/// What kernels and transfers wrote is there for vertex shaders, and what they read may be written by copies.
void barrierToDraw(const VolkDeviceTable& call, VkCommandBuffer commands) {
    auto memory = vk::init<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    call.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                              VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &memory, 0,
                              nullptr, 0, nullptr);
}

/// A shader module for as long as a pipeline is made from it.
class Module {
public:
    Module(Device::State& device, std::string_view name, std::span<const uint32_t> spirv, const Constants& constants)
        : device_(device) {
        const std::vector<uint32_t> special = vk::specialize(name, spirv, constants);
        auto code = vk::init<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
        code.codeSize = special.size() * sizeof(uint32_t);
        code.pCode = special.data();
        vk::check(device.call.vkCreateShaderModule(device.handle, &code, nullptr, &handle_), "load a shader");
    }
    ~Module() { device_.call.vkDestroyShaderModule(device_.handle, handle_, nullptr); }
    Module(const Module&) = delete;
    Module& operator=(const Module&) = delete;

    VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits kind) const {
        auto stage = vk::init<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
        stage.stage = kind;
        stage.module = handle_;
        stage.pName = "main";
        return stage;
    }

private:
    Device::State& device_;
    VkShaderModule handle_ = VK_NULL_HANDLE;
};

}  // namespace

struct Raster::State {
    State(Device::State& opened, std::string_view called, KernelInterface read, uint32_t width, uint32_t height)
        : device(opened), name(called), interface(std::move(read)), target(opened, width, height), recorder(opened) {
        pipeline.device = &device;
    }
    ~State() { device.call.vkDestroyDescriptorPool(device.handle, pool, nullptr); }

    void makeLayouts();
    void makePipeline(std::span<const uint32_t> vertex, std::span<const uint32_t> fragment, const Constants& constants);
    const KernelBinding& declared(uint32_t binding, uint32_t count) const;
    void write(uint32_t binding, const KernelBinding& as, std::span<const std::shared_ptr<vk::BufferState>> buffers);
    void beginPass(uint32_t width, uint32_t height, bool clears);

    Device::State& device;
    std::string name;
    KernelInterface interface;
    vk::RasterTarget target;
    vk::Pipeline pipeline;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
    vk::Recorder recorder;
    std::map<uint32_t, bool> bound;
    bool drawn = false;
};

void Raster::State::makeLayouts() {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    uint32_t storage = 0, texel = 0;
    for (const auto& [number, binding] : interface.bindings) {
        bindings.push_back({number, typeOf(binding), binding.count, VK_SHADER_STAGE_VERTEX_BIT, nullptr});
        (binding.kind == KernelBinding::Kind::texel ? texel : storage) += binding.count;
    }
    if (storage > device.storageDescriptors || texel > device.texelDescriptors)
        throw deviceError("device '{}' lets a shader have {} storage and {} texel buffers, and {} needs {} and {}; "
                          "--device names another",
                          device.info.name, device.storageDescriptors, device.texelDescriptors, name, storage, texel);
    auto layout = vk::init<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    layout.bindingCount = static_cast<uint32_t>(bindings.size());
    layout.pBindings = bindings.data();
    vk::check(device.call.vkCreateDescriptorSetLayout(device.handle, &layout, nullptr, &pipeline.setLayout),
              "lay out a shader");
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, interface.pushBytes};
    auto all = vk::init<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    all.setLayoutCount = 1;
    all.pSetLayouts = &pipeline.setLayout;
    all.pushConstantRangeCount = 1;
    all.pPushConstantRanges = &push;
    vk::check(device.call.vkCreatePipelineLayout(device.handle, &all, nullptr, &pipeline.layout), "lay out a shader");

    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, std::max(storage, 1u)},
                                          {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, std::max(texel, 1u)}};
    auto makePool = vk::init<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    makePool.maxSets = 1;
    makePool.poolSizeCount = 2;
    makePool.pPoolSizes = sizes;
    vk::check(device.call.vkCreateDescriptorPool(device.handle, &makePool, nullptr, &pool), "bind buffers");
    auto allocate = vk::init<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    allocate.descriptorPool = pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &pipeline.setLayout;
    vk::check(device.call.vkAllocateDescriptorSets(device.handle, &allocate, &set), "bind buffers");
}

void Raster::State::makePipeline(std::span<const uint32_t> vertex, std::span<const uint32_t> fragment,
                                 const Constants& constants) {
    const Module vertices(device, name, vertex, constants), fragments(device, name, fragment, constants);
    const VkPipelineShaderStageCreateInfo stages[] = {vertices.stage(VK_SHADER_STAGE_VERTEX_BIT),
                                                      fragments.stage(VK_SHADER_STAGE_FRAGMENT_BIT)};
    const auto input =
        vk::init<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
    auto assembly =
        vk::init<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    auto viewport = vk::init<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
    viewport.viewportCount = viewport.scissorCount = 1;
    auto lines =
        vk::init<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
    lines.polygonMode = VK_POLYGON_MODE_FILL;
    lines.cullMode = VK_CULL_MODE_NONE;
    lines.lineWidth = 1.0f;
    auto samples = vk::init<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    auto depth = vk::init<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState words{};
    words.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT;
    auto blend = vk::init<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
    blend.attachmentCount = 1;
    blend.pAttachments = &words;
    const VkDynamicState sized[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    auto dynamic = vk::init<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = sized;

    auto create = vk::init<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
    create.stageCount = 2;
    create.pStages = stages;
    create.pVertexInputState = &input;
    create.pInputAssemblyState = &assembly;
    create.pViewportState = &viewport;
    create.pRasterizationState = &lines;
    create.pMultisampleState = &samples;
    create.pDepthStencilState = &depth;
    create.pColorBlendState = &blend;
    create.pDynamicState = &dynamic;
    create.layout = pipeline.layout;
    create.renderPass = target.pass(/* clears= */ true);
    vk::check(device.call.vkCreateGraphicsPipelines(device.handle, device.cache, 1, &create, nullptr, &pipeline.handle),
              fmt::format("compile {}", name).c_str());
    device.cacheGrew = true;
}

const KernelBinding& Raster::State::declared(uint32_t binding, uint32_t count) const {
    const auto found = interface.bindings.find(binding);
    if (found == interface.bindings.end() || count > found->second.count)
        checkFailed(__FILE__, __LINE__, fmt::format("{}: binding {} takes {} buffers", name, binding, count));
    return found->second;
}

void Raster::State::write(uint32_t binding, const KernelBinding& as,
                          std::span<const std::shared_ptr<vk::BufferState>> buffers) {
    std::vector<VkDescriptorBufferInfo> infos;
    std::vector<VkBufferView> views;
    for (uint32_t i = 0; i < as.count; ++i) {  // descriptors beyond the last buffer are that one's
        const vk::BufferState& buffer = *buffers[std::min<size_t>(i, buffers.size() - 1)];
        RAIG_CHECK(buffer.device == &device);
        RAIG_CHECK(as.kind == KernelBinding::Kind::texel ? buffer.view != VK_NULL_HANDLE : buffer.storage);
        infos.push_back({buffer.buffer, 0, buffer.bytes});
        views.push_back(buffer.view);
    }
    auto update = vk::init<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    update.dstSet = set;
    update.dstBinding = binding;
    update.descriptorCount = as.count;
    update.descriptorType = typeOf(as);
    update.pBufferInfo = infos.data();
    update.pTexelBufferView = views.data();
    device.call.vkUpdateDescriptorSets(device.handle, 1, &update, 0, nullptr);
    bound[binding] = true;
}

void Raster::State::beginPass(uint32_t width, uint32_t height, bool clears) {
    const VkCommandBuffer commands = recorder.commands;
    target.begin(commands, width, height, clears);
    device.call.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.handle);
    device.call.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout, 0, 1, &set, 0, nullptr);
    const VkViewport viewport{0.0f, 0.0f, float(width), float(height), 0.0f, 1.0f};
    const VkRect2D all{{0, 0}, {width, height}};
    device.call.vkCmdSetViewport(commands, 0, 1, &viewport);
    device.call.vkCmdSetScissor(commands, 0, 1, &all);
}

Raster::Raster(Device& device, std::string_view name, std::span<const uint32_t> vertex, std::span<const uint32_t> fragment,
               const Constants& constants, uint32_t width, uint32_t height) {
    RAIG_CHECK(device.state().options.graphics);
    RAIG_CHECK(width > 0 && height > 0 && std::max(width, height) <= largestSide(device));
    state_ = std::make_unique<State>(device.state(), name, reflect(name, vertex, constants), width, height);
    RAIG_CHECK_OP(state_->interface.pushBytes, <=, device.info().limits.pushConstantBytes);
    RAIG_CHECK_OP(state_->interface.pushBytes, >=, sizeof(Draw::words));
    state_->makeLayouts();
    state_->makePipeline(vertex, fragment, constants);
}

Raster::~Raster() = default;

uint32_t Raster::largestSide(const Device& device) {
    return device.info().limits.framebufferSide;
}

void Raster::bind(uint32_t binding, const Buffer& buffer) {
    state_->write(binding, state_->declared(binding, 1), std::array{buffer.state()});
}

void Raster::bind(uint32_t binding, const BigArray& array) {
    std::vector<std::shared_ptr<vk::BufferState>> chunks;
    for (uint32_t i = 0; i < array.chunkCount(); ++i) chunks.push_back(array.chunk(i).state());
    state_->write(binding, state_->declared(binding, array.chunkCount()), chunks);
}

double Raster::draw(uint32_t width, uint32_t height, bool clears, std::span<const std::byte> push,
                    std::span<const Draw> draws) {
    State& state = *state_;
    const VolkDeviceTable& call = state.device.call;
    RAIG_CHECK(width > 0 && height > 0 && width <= state.target.width() && height <= state.target.height());
    RAIG_CHECK_OP(push.size() + sizeof(Draw::words), ==, state.interface.pushBytes);
    RAIG_CHECK_OP(state.bound.size(), ==, state.interface.bindings.size());
    RAIG_CHECK(clears || state.drawn);
    const Clock::time_point start = Clock::now();
    state.recorder.begin();
    const VkCommandBuffer commands = state.recorder.commands;
    barrierToDraw(call, commands);
    state.beginPass(width, height, clears);
    const auto common = static_cast<uint32_t>(push.size());
    call.vkCmdPushConstants(commands, state.pipeline.layout, VK_SHADER_STAGE_VERTEX_BIT, 0, common, push.data());
    for (const Draw& one : draws) {
        RAIG_CHECK_OP(one.triangles, <=, 0xffffffffu / 3);
        if (one.triangles == 0 || one.instances == 0) continue;
        call.vkCmdPushConstants(commands, state.pipeline.layout, VK_SHADER_STAGE_VERTEX_BIT, common, sizeof(one.words),
                                one.words.data());
        call.vkCmdDraw(commands, 3 * one.triangles, one.instances, 0, 0);
    }
    call.vkCmdEndRenderPass(commands);
    state.recorder.submit();
    state.recorder.wait();
    state.drawn = true;
    return secondsSince(start);
}

double Raster::copy(uint32_t width, uint32_t height, Buffer& to, uint64_t offset, uint32_t rowPixels) {
    State& state = *state_;
    RAIG_CHECK(state.drawn && width > 0 && height > 0 && width <= state.target.width() && height <= state.target.height());
    RAIG_CHECK(offset % 8 == 0 && rowPixels >= width);
    RAIG_CHECK_OP(offset + 8 * (uint64_t{rowPixels} * (height - 1) + width), <=, to.bytes());
    const Clock::time_point start = Clock::now();
    state.recorder.begin();
    barrierToDraw(state.device.call, state.recorder.commands);
    state.target.copy(state.recorder.commands, width, height, to.state()->buffer, offset, rowPixels);
    vk::barrierToHost(state.device.call, state.recorder.commands);
    state.recorder.submit();
    state.recorder.wait();
    return secondsSince(start);
}

}  // namespace raig

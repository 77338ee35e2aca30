#include "device/kernel.hpp"

#include "device/specialize.hpp"
#include "device/vulkan.hpp"

namespace raig {

namespace {

/// Ends the program unless `condition` holds of the kernel.
void require(bool condition, std::string_view kernel, const std::string& what) {
    if (!condition) checkFailed(__FILE__, __LINE__, fmt::format("kernel {}: {}", kernel, what));
}

VkDescriptorType descriptorType(KernelBinding::Kind kind) {
    return kind == KernelBinding::Kind::texel ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

void checkLimits(const Kernel::State& kernel) {
    const DeviceLimits& limits = kernel.device->info.limits;
    const auto& size = kernel.interface.workgroupSize;
    uint64_t invocations = 1;
    for (int axis = 0; axis < 3; ++axis) {
        require(size[axis] >= 1 && size[axis] <= limits.workgroupSize[axis], kernel.name,
                fmt::format("workgroup size {} of axis {} is within 1 to {}", size[axis], axis, limits.workgroupSize[axis]));
        invocations *= size[axis];
    }
    require(invocations <= limits.workgroupInvocations, kernel.name,
            fmt::format("{} invocations a workgroup are within {}", invocations, limits.workgroupInvocations));
    require(kernel.interface.pushBytes <= limits.pushConstantBytes, kernel.name,
            fmt::format("{} bytes of push constants are within {}", kernel.interface.pushBytes, limits.pushConstantBytes));
    if (kernel.storageDescriptors > kernel.device->storageDescriptors ||
        kernel.texelDescriptors > kernel.device->texelDescriptors)
        throw deviceError(
            "device '{}' lets a kernel have {} storage and {} texel buffers, and {} needs {} and {}; "
            "--device names another",
            kernel.device->info.name, kernel.device->storageDescriptors, kernel.device->texelDescriptors, kernel.name,
            kernel.storageDescriptors, kernel.texelDescriptors);
}

void makeLayouts(const Kernel::State& kernel, vk::Pipeline& made) {
    const Device::State& device = *kernel.device;
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const auto& [number, binding] : kernel.interface.bindings)
        bindings.push_back({number, descriptorType(binding.kind), binding.count, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo set =
        vk::init<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    set.bindingCount = static_cast<uint32_t>(bindings.size());
    set.pBindings = bindings.data();
    vk::check(device.call.vkCreateDescriptorSetLayout(device.handle, &set, nullptr, &made.setLayout), "lay out a kernel");

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, kernel.interface.pushBytes};
    VkPipelineLayoutCreateInfo layout = vk::init<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &made.setLayout;
    layout.pushConstantRangeCount = push.size > 0 ? 1 : 0;
    layout.pPushConstantRanges = &push;
    vk::check(device.call.vkCreatePipelineLayout(device.handle, &layout, nullptr, &made.layout), "lay out a kernel");
}

void makePipeline(const Kernel::State& kernel, std::span<const uint32_t> spirv, const Constants& constants,
                  vk::Pipeline& made) {
    Device::State& device = *kernel.device;
    const std::vector<uint32_t> special = vk::specialize(kernel.name, spirv, constants);
    VkShaderModuleCreateInfo code = vk::init<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    code.codeSize = special.size() * sizeof(uint32_t);
    code.pCode = special.data();
    VkComputePipelineCreateInfo create =
        vk::init<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.pName = "main";
    create.layout = made.layout;
    vk::check(device.call.vkCreateShaderModule(device.handle, &code, nullptr, &create.stage.module), "load a kernel");
    const VkResult result =
        device.call.vkCreateComputePipelines(device.handle, device.cache, 1, &create, nullptr, &made.handle);
    device.call.vkDestroyShaderModule(device.handle, create.stage.module, nullptr);
    vk::check(result, fmt::format("compile kernel {}", kernel.name).c_str());
    device.cacheGrew = true;
}

/// The device's, made unless it is there already.
const vk::Pipeline& pipelineOf(const Kernel::State& kernel, std::span<const uint32_t> spirv, const Constants& constants) {
    vk::PipelineKey key{kernel.name, constants, std::vector<uint32_t>(spirv.begin(), spirv.end())};
    const auto found = kernel.device->pipelines.find(key);
    if (found != kernel.device->pipelines.end()) return *found->second;
    auto made = std::make_unique<vk::Pipeline>();
    made->device = kernel.device;
    makeLayouts(kernel, *made);
    makePipeline(kernel, spirv, constants, *made);
    return *kernel.device->pipelines.emplace(std::move(key), std::move(made)).first->second;
}

}  // namespace

Kernel::Kernel(Device& device, std::string_view name, std::span<const uint32_t> spirv, const Constants& constants)
    : state_(std::make_unique<State>()) {
    state_->device = &device.state();
    state_->name = name;
    state_->interface = reflect(name, spirv, constants);
    for (const auto& [number, binding] : state_->interface.bindings)
        (binding.kind == KernelBinding::Kind::texel ? state_->texelDescriptors : state_->storageDescriptors) +=
            binding.count;
    checkLimits(*state_);
    const vk::Pipeline& pipeline = pipelineOf(*state_, spirv, constants);
    state_->setLayout = pipeline.setLayout;
    state_->layout = pipeline.layout;
    state_->pipeline = pipeline.handle;
}

Kernel::~Kernel() = default;
Kernel::Kernel(Kernel&&) noexcept = default;
Kernel& Kernel::operator=(Kernel&&) noexcept = default;

vk::Pipeline::~Pipeline() {
    device->call.vkDestroyPipeline(device->handle, handle, nullptr);
    device->call.vkDestroyPipelineLayout(device->handle, layout, nullptr);
    device->call.vkDestroyDescriptorSetLayout(device->handle, setLayout, nullptr);
}

const KernelInterface& Kernel::interface() const {
    return state_->interface;
}

void Kernel::bind(uint32_t number, const Buffer& buffer) {
    const auto found = state_->interface.bindings.find(number);
    require(found != state_->interface.bindings.end(), state_->name, fmt::format("binding {} is declared", number));
    require(found->second.count == 1, state_->name, fmt::format("binding {} is one buffer", number));
    require(found->second.kind == KernelBinding::Kind::storage || buffer.state()->view != VK_NULL_HANDLE, state_->name,
            fmt::format("the buffer of binding {} can be read as texels", number));
    require(buffer.state()->device == state_->device, state_->name,
            fmt::format("the buffer of binding {} is its device's", number));
    state_->bound[number].buffers = {buffer.state()};
}

void Kernel::bind(uint32_t number, const BigArray& array) {
    const auto found = state_->interface.bindings.find(number);
    require(found != state_->interface.bindings.end(), state_->name, fmt::format("binding {} is declared", number));
    const KernelBinding& binding = found->second;
    require(array.chunkCount() <= binding.count, state_->name,
            fmt::format("the {} chunks of binding {} fit its {} descriptors", array.chunkCount(), number, binding.count));
    std::vector<std::weak_ptr<vk::BufferState>> buffers;
    for (uint32_t i = 0; i < binding.count; ++i) {
        const auto& buffer = array.chunk(std::min(i, array.chunkCount() - 1)).state();
        require(buffer->device == state_->device, state_->name,
                fmt::format("the array of binding {} is its device's", number));
        require(binding.kind == KernelBinding::Kind::texel ? buffer->view != VK_NULL_HANDLE : buffer->storage, state_->name,
                fmt::format("the array of binding {} was made for descriptors of its kind", number));
        buffers.push_back(buffer);
    }
    state_->bound[number].buffers = std::move(buffers);
}

}  // namespace raig

#include "device/raster_target.hpp"

#include "device/raster.hpp"

#include <array>

namespace raig::vk {

namespace {

constexpr VkFormat wordsFormat = VK_FORMAT_R32G32_UINT;  // every device draws into it

/// The best format of depth that the device has; every device has one of these.
VkFormat chooseDepthFormat(const Device::State& device) {
    for (const VkFormat format : {VK_FORMAT_D32_SFLOAT, VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D16_UNORM}) {
        VkFormatProperties found{};
        vkGetPhysicalDeviceFormatProperties(device.physical, format, &found);
        if (found.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT) return format;
    }
    throw deviceError("device '{}' cannot draw with depth; --device names another", device.info.name);
}

uint32_t memoryTypeOf(const Device::State& device, uint32_t allowed) {
    for (const VkMemoryPropertyFlags wanted : {VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT}, 0u})
        for (uint32_t i = 0; i < device.memory.memoryTypeCount; ++i)
            if ((allowed >> i & 1u) != 0 && (device.memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    throw deviceError("device '{}' has no memory fit for pictures; --device names another", device.info.name);
}

void makeImage(Device::State& device, TargetImage& made, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect,
               uint32_t width, uint32_t height) {
    made.device = &device;
    auto create = init<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = format;
    create.extent = {width, height, 1};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.tiling = VK_IMAGE_TILING_OPTIMAL;
    create.usage = usage;
    check(device.call.vkCreateImage(device.handle, &create, nullptr, &made.image), "make a picture to draw into");
    VkMemoryRequirements needs{};
    device.call.vkGetImageMemoryRequirements(device.handle, made.image, &needs);
    auto allocate = init<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = memoryTypeOf(device, needs.memoryTypeBits);
    check(device.call.vkAllocateMemory(device.handle, &allocate, nullptr, &made.memory), "allocate a picture to draw into");
    check(device.call.vkBindImageMemory(device.handle, made.image, made.memory, 0), "give a picture its memory");
    auto view = init<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = made.image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {aspect, 0, 1, 0, 1};
    check(device.call.vkCreateImageView(device.handle, &view, nullptr, &made.view), "draw into a picture");
}

}  // namespace

TargetImage::~TargetImage() {
    if (device == nullptr) return;
    device->call.vkDestroyImageView(device->handle, view, nullptr);
    device->call.vkDestroyImage(device->handle, image, nullptr);
    device->call.vkFreeMemory(device->handle, memory, nullptr);
}

RasterTarget::RasterTarget(Device::State& device, uint32_t width, uint32_t height)
    : device_(device), width_(width), height_(height) {
    const VkFormat depthFormat = chooseDepthFormat(device);
    makeImage(device, words_, wordsFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
              VK_IMAGE_ASPECT_COLOR_BIT, width, height);
    makeImage(device, depth_, depthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, width,
              height);
    clearing_ = makePass(depthFormat, true);
    keeping_ = makePass(depthFormat, false);
    const VkImageView views[] = {words_.view, depth_.view};
    auto create = init<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
    create.renderPass = clearing_;
    create.attachmentCount = 2;
    create.pAttachments = views;
    create.width = width;
    create.height = height;
    create.layers = 1;
    check(device.call.vkCreateFramebuffer(device.handle, &create, nullptr, &framebuffer_), "draw into a picture");
}

RasterTarget::~RasterTarget() {
    device_.call.vkDestroyFramebuffer(device_.handle, framebuffer_, nullptr);
    device_.call.vkDestroyRenderPass(device_.handle, clearing_, nullptr);
    device_.call.vkDestroyRenderPass(device_.handle, keeping_, nullptr);
}

VkRenderPass RasterTarget::makePass(VkFormat depthFormat, bool clears) const {
    VkAttachmentDescription words{};
    words.format = wordsFormat;
    words.samples = VK_SAMPLE_COUNT_1_BIT;
    words.loadOp = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
    words.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    words.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    words.initialLayout = clears ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    words.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    VkAttachmentDescription depth = words;
    depth.format = depthFormat;
    depth.initialLayout = clears ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    depth.finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    const VkAttachmentDescription attachments[] = {words, depth};
    const VkAttachmentReference wordsThere{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depthThere{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &wordsThere;
    subpass.pDepthStencilAttachment = &depthThere;

    // After earlier passes, and copies out of them; before later copies.
    constexpr VkPipelineStageFlags drawing = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags written =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    constexpr VkAccessFlags read = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    const VkSubpassDependency order[] = {{VK_SUBPASS_EXTERNAL, 0, drawing | VK_PIPELINE_STAGE_TRANSFER_BIT, drawing, written,
                                          written | read, 0},
                                         {0, VK_SUBPASS_EXTERNAL, drawing, VK_PIPELINE_STAGE_TRANSFER_BIT, written,
                                          VK_ACCESS_TRANSFER_READ_BIT, 0}};
    auto create = init<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    create.attachmentCount = 2;
    create.pAttachments = attachments;
    create.subpassCount = 1;
    create.pSubpasses = &subpass;
    create.dependencyCount = 2;
    create.pDependencies = order;
    VkRenderPass made = VK_NULL_HANDLE;
    check(device_.call.vkCreateRenderPass(device_.handle, &create, nullptr, &made), "draw into a picture");
    return made;
}

void RasterTarget::begin(VkCommandBuffer commands, uint32_t width, uint32_t height, bool clears) const {
    VkClearValue clear[2]{};
    clear[0].color.uint32[0] = clear[0].color.uint32[1] = Raster::nothing;
    clear[1].depthStencil.depth = 0.0f;
    auto pass = init<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    pass.renderPass = clears ? clearing_ : keeping_;
    pass.framebuffer = framebuffer_;
    pass.renderArea = {{0, 0}, {width, height}};
    pass.clearValueCount = 2;
    pass.pClearValues = clear;
    device_.call.vkCmdBeginRenderPass(commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
}

void RasterTarget::copy(VkCommandBuffer commands, uint32_t width, uint32_t height, VkBuffer to, uint64_t offset,
                        uint32_t rowPixels) const {
    VkBufferImageCopy region{};
    region.bufferOffset = offset;
    region.bufferRowLength = rowPixels;
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {width, height, 1};
    device_.call.vkCmdCopyImageToBuffer(commands, words_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to, 1, &region);
}

}  // namespace raig::vk

/// The pictures that a Raster draws into: two words a pixel, and depth. For this folder alone.
#pragma once

#include "device/vulkan.hpp"

namespace raig::vk {

/// An image of one layer in the device's memory.
struct TargetImage {
    Device::State* device = nullptr;
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;

    TargetImage() = default;
    TargetImage(const TargetImage&) = delete;
    TargetImage& operator=(const TargetImage&) = delete;
    ~TargetImage();
};

class RasterTarget {
public:
    /// Throws limitError if memory is short, deviceError if the device has no such images.
    RasterTarget(Device::State& device, uint32_t width, uint32_t height);
    ~RasterTarget();
    RasterTarget(const RasterTarget&) = delete;
    RasterTarget& operator=(const RasterTarget&) = delete;

    uint32_t width() const { return width_; }
    uint32_t height() const { return height_; }

    /// Of both kinds the same pipelines can draw.
    VkRenderPass pass(bool clears) const { return clears ? clearing_ : keeping_; }

    /// Begins a pass over the upper left width x height pixels, cleared or as the last pass left them.
    void begin(VkCommandBuffer commands, uint32_t width, uint32_t height, bool clears) const;

    /// Copies them into `to`, rows `rowPixels` apart.
    void copy(VkCommandBuffer commands, uint32_t width, uint32_t height, VkBuffer to, uint64_t offset,
              uint32_t rowPixels) const;

private:
    VkRenderPass makePass(VkFormat depth, bool clears) const;

    Device::State& device_;
    uint32_t width_;
    uint32_t height_;
    TargetImage words_, depth_;
    VkRenderPass clearing_ = VK_NULL_HANDLE;
    VkRenderPass keeping_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
};

}  // namespace raig::vk

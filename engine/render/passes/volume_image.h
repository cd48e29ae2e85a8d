// A 3-D image that shaders sample. x is the last axis of the array.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "engine/gpu/resources.h"

namespace typodont::render {

struct VolumeImage {
  static constexpr VkPipelineStageFlags2 kReaders =
      VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  gpu::Allocation memory;

  static VkExtent3D extent_of(const glm::ivec3& size) {
    return {static_cast<std::uint32_t>(size.z), static_cast<std::uint32_t>(size.y), static_cast<std::uint32_t>(size.x)};
  }
  /// Creates an image of `size` texels, filled with zero, in the layout for shaders.
  void create(gpu::Device& device, const glm::ivec3& size, VkFormat format);
  /// Copies parts of the image from a buffer; must be recorded outside a rendering pass.
  void copy(VkCommandBuffer commands, VkBuffer from, std::span<const VkBufferImageCopy> parts) const;
  void destroy(gpu::Device& device);
};

}  // namespace typodont::render

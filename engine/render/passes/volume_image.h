// A three-dimensional image that shaders sample. Its x axis is the last axis of the array that fills it.
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
  /// Makes an image of `size` texels, all zero, in the layout that shaders read.
  void create(gpu::Device& device, const glm::ivec3& size, VkFormat format);
  /// Records copies from a buffer to the image. The recorded commands must not be inside a rendering pass.
  void copy(VkCommandBuffer commands, VkBuffer from, std::span<const VkBufferImageCopy> parts) const;
  void destroy(gpu::Device& device);
};

}  // namespace typodont::render

// Device, formats, frame data and counters that all render passes share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/gpu/resources.h"
#include "engine/render/quality.h"
#include "engine/render/renderer.h"
#include "engine/render/shared.h"

namespace typodont::render {

// Format that converts linear light to sRGB when written, so samples are averaged in linear light.
inline constexpr VkFormat kColorFormat = VK_FORMAT_R8G8B8A8_SRGB;
// Format of a view that gives access to the image's sRGB bytes without conversion to linear colours.
inline constexpr VkFormat kColorBytes = VK_FORMAT_R8G8B8A8_UNORM;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

struct PassContext {
  gpu::Device& device;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  int samples = 1;
  std::uint32_t view_mask = 3;
  Quality quality;

  /// Specialisation constants for frame.glsl.
  std::vector<std::uint32_t> constants() const {
    return {static_cast<std::uint32_t>(quality.shadow_taps), static_cast<std::uint32_t>(quality.occlusion_taps),
            quality.light_per_vertex ? 1u : 0u};
  }
  /// Options of pipelines that draw into the eyes' pictures.
  gpu::PipelineOptions scene_pipeline(std::span<const std::uint32_t> vertex,
                                      std::span<const std::uint32_t> fragment) const {
    gpu::PipelineOptions o;
    o.vertex_shader = vertex;
    o.fragment_shader = fragment;
    o.layout = layout;
    o.color = kColorFormat;
    o.depth = kDepthFormat;
    o.samples = samples;
    o.view_mask = view_mask;
    o.constants = constants();
    return o;
  }
};

/// Buffers, one per frame in flight, that grow as needed.
struct SlotBuffers {
  std::array<gpu::Buffer, gpu::FrameRing::kSlots> buffers;
  /// Returns the slot's buffer with at least `size` bytes. The slot's last commands must have finished.
  gpu::Buffer& at_least(gpu::Device& device, int slot, VkDeviceSize size, VkBufferUsageFlags usage) {
    gpu::Buffer& b = buffers[static_cast<std::size_t>(slot)];
    if (b.size < size) {
      b.destroy(device);
      b = gpu::Buffer::create(device, std::max<VkDeviceSize>(size + size / 2, 4096), usage);
    }
    return b;
  }
  void destroy(gpu::Device& device) {
    for (gpu::Buffer& b : buffers) b.destroy(device);
  }
};

inline constexpr VkShaderStageFlags kPushStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// Sets ObjectData::view for the next draws. `omitted_fraction`: fraction of the tool's pixels that are left out;
/// `open_radius`: radius at the working point of the view cone in which the handpiece is not drawn, m.
inline void push_view(VkCommandBuffer commands, VkPipelineLayout layout, int view, double omitted_fraction = 0,
                      double open_radius = 0) {
  const glm::vec4 value(static_cast<float>(view), static_cast<float>(omitted_fraction), static_cast<float>(open_radius),
                        0);
  vkCmdPushConstants(commands, layout, kPushStages, offsetof(shared::ObjectData, view), sizeof value, &value);
}

inline void push(VkCommandBuffer commands, VkPipelineLayout layout, const Pose& X_WM) {
  // The rows of the rotation R are the columns of its transpose, which GLM can return.
  const glm::dmat3 r = glm::transpose(glm::mat3_cast(X_WM.R));
  shared::ObjectData object;
  for (int i = 0; i < 3; ++i) object.world_row[i] = glm::vec4(glm::dvec4(r[i], X_WM.p[i]));
  vkCmdPushConstants(commands, layout, kPushStages, 0, sizeof object.world_row, &object);
}

/// Draws vertices from a buffer with the bound pipeline.
inline void draw_vertices(VkCommandBuffer commands, VkBuffer vertices, std::uint32_t count, FrameStats& stats,
                          std::uint32_t first = 0) {
  const VkDeviceSize zero = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &zero);
  vkCmdDraw(commands, count, 1, first, 0);
  ++stats.commands;
}

}  // namespace typodont::render

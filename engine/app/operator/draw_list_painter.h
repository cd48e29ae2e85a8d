// Dear ImGui's draw lists with Vulkan: one pipeline, dynamic rendering, two frames in flight. Redraws only what differs
// from the target's earlier frame. Render thread only.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "engine/display/output.h"
#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"

struct ImDrawData;

namespace typodont {

class DrawListPainter {
 public:
  /// The current context's font atlas. Throws RunFailure.
  explicit DrawListPainter(gpu::Device& device);
  ~DrawListPainter();
  DrawListPainter(const DrawListPainter&) = delete;
  DrawListPainter& operator=(const DrawListPainter&) = delete;

  /// After language or scale have changed; no frame in flight.
  void take_font_atlas();

  /// Forgets the last frame's textures.
  void new_frame();
  /// The first layer as a texture for ImGui::Image in this frame: sRGB bytes in a UNORM view, in the shaders' layout;
  /// at most 60. `shows` changes with the content.
  void* texture(VkImageView array_view, std::uint64_t shows);

  /// Draws what differs from the content of `target`, or everything (`all`, or no frame there). Returns the parts;
  /// empty: everything.
  std::optional<std::vector<display::Part>> record(VkCommandBuffer commands, const ImDrawData& lists,
                                                   const display::Target& target, int slot,
                                                   const std::array<float, 4>& clear, bool all = false);

 private:
  static constexpr int kSlots = gpu::FrameRing::kSlots;
  static constexpr std::size_t kTextures = 64;  // in a frame; the first is the font

  struct Texture {
    VkImageView view;
    int layer;  // of an array; negative: the font, coverage only
    std::uint64_t shows;
  };

  void draw(VkCommandBuffer commands, const ImDrawData& lists, const display::Target& target, std::size_t slot,
            const std::vector<display::Part>& parts);

  gpu::Device& device_;
  gpu::Image font_;
  VkSampler sampler_ = VK_NULL_HANDLE;
  gpu::ShaderInputs inputs_;  // each slot has a descriptor set per texture
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  std::array<gpu::Buffer, kSlots> vertices_, indices_;
  std::vector<Texture> textures_;
  // per target: a hash per tile of what was drawn last
  std::map<VkImage, std::vector<std::uint64_t>> holds_;
};

}  // namespace typodont

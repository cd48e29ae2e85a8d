// Draws Dear ImGui's draw lists with Vulkan: one pipeline, dynamic rendering, two frames in flight. Redraws only what
// differs from the last content of the target. Render thread only.
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
  /// Uploads the font atlas of the current ImGui context. Throws RunFailure.
  explicit DrawListPainter(gpu::Device& device);
  ~DrawListPainter();
  DrawListPainter(const DrawListPainter&) = delete;
  DrawListPainter& operator=(const DrawListPainter&) = delete;

  /// Uploads the font atlas again, after a change of language or scale. Call when no frame is in flight.
  void take_font_atlas();

  /// Forgets the textures of the last frame.
  void new_frame();
  /// Makes the first layer of an image a texture for ImGui::Image in this frame; at most 63 textures. Format: sRGB
  /// bytes in a UNORM view, image layout for reading in shaders. `shows`: a number that changes with the content.
  void* texture(VkImageView array_view, std::uint64_t shows);

  /// Draws what differs from the content of `target`; everything if `all` is true or the target has no content yet.
  /// Returns the drawn parts; empty: everything was drawn.
  std::optional<std::vector<display::Part>> record(VkCommandBuffer commands, const ImDrawData& lists,
                                                   const display::Target& target, int slot,
                                                   const std::array<float, 4>& clear, bool all = false);

 private:
  static constexpr int kSlots = gpu::FrameRing::kSlots;
  static constexpr std::size_t kTextures = 64;  // largest number of textures in a frame; the first one is the font

  struct Texture {
    VkImageView view;
    int layer;  // layer of the array image; negative: the font, which stores only coverage
    std::uint64_t shows;
  };

  void draw(VkCommandBuffer commands, const ImDrawData& lists, const display::Target& target, std::size_t slot,
            const std::vector<display::Part>& parts);

  gpu::Device& device_;
  gpu::Image font_;
  VkSampler sampler_ = VK_NULL_HANDLE;
  gpu::ShaderInputs inputs_;  // for each frame in flight, one descriptor set per texture
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  std::array<gpu::Buffer, kSlots> vertices_, indices_;
  std::vector<Texture> textures_;
  // For each target image: a hash of each tile's content when it was last drawn.
  std::map<VkImage, std::vector<std::uint64_t>> holds_;
};

}  // namespace typodont

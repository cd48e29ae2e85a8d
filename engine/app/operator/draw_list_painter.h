// Dear ImGui's draw lists on our Vulkan: one pipeline, dynamic rendering, two frames in flight. A target that still
// holds an earlier frame is drawn where that differs. Render thread.
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
  /// Takes the current ImGui context's font atlas. Throws RunFailure.
  explicit DrawListPainter(gpu::Device& device);
  ~DrawListPainter();
  DrawListPainter(const DrawListPainter&) = delete;
  DrawListPainter& operator=(const DrawListPainter&) = delete;

  /// The atlas has changed (another language, another scale): takes it up anew. Nothing may be in flight.
  void take_font_atlas();

  /// Forgets the last frame's textures.
  void new_frame();
  /// A picture for ImGui::Image during this frame, the first layer: sRGB bytes (a UNORM view), ready for shaders. At
  /// most 60 a frame. `shows`: another number once it shows something else.
  void* texture(VkImageView array_view, std::uint64_t shows);

  /// Draws what the target lacks of this frame; all of it where it holds none, or where `all` is wanted. Returns the
  /// parts that were drawn; nothing: all.
  std::optional<std::vector<display::Part>> record(VkCommandBuffer commands, const ImDrawData& lists,
                                                   const display::Target& target, int slot,
                                                   const std::array<float, 4>& clear, bool all = false);

 private:
  static constexpr int kSlots = gpu::FrameRing::kSlots;
  static constexpr std::size_t kTextures = 64;  // the first is the font's

  struct Texture {
    VkImageView view;
    int layer;  // of an array; negative: the font's coverage
    std::uint64_t shows;
  };

  void draw(VkCommandBuffer commands, const ImDrawData& lists, const display::Target& target, std::size_t slot,
            const std::vector<display::Part>& parts);

  gpu::Device& device_;
  gpu::Image font_;
  VkSampler sampler_ = VK_NULL_HANDLE;
  gpu::ShaderInputs inputs_;  // a set for each slot's textures
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  std::array<gpu::Buffer, kSlots> vertices_, indices_;
  std::vector<Texture> textures_;
  std::map<VkImage, std::vector<std::uint64_t>> holds_;  // the tiles of the frame that a target was given last
};

}  // namespace typodont

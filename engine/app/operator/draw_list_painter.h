// Draws the user interface (Dear ImGui's draw lists) with Vulkan: one pipeline, dynamic rendering, two frames in
// flight. If the target image still contains an earlier frame, draws only the parts that differ from it. Render thread
// only.
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

  /// Uploads the font atlas again. Call it after the language or the scale has changed, while the GPU draws no frame.
  void take_font_atlas();

  /// Begins a frame: removes the textures that were registered for the last frame.
  void new_frame();
  /// Registers the first layer of a picture as a texture that ImGui::Image draws in this frame. The picture must
  /// contain sRGB bytes (a UNORM view) and be in the layout for shaders. At most 60 pictures per frame. `shows`: a
  /// number that changes whenever the picture's content changes.
  void* texture(VkImageView array_view, std::uint64_t shows);

  /// Draws the parts of the frame that differ from the content of the image `target`. Draws everything if the image
  /// contains no frame, or if `all` is true. Returns the drawn parts; an empty optional means that everything was
  /// drawn.
  std::optional<std::vector<display::Part>> record(VkCommandBuffer commands, const ImDrawData& lists,
                                                   const display::Target& target, int slot,
                                                   const std::array<float, 4>& clear, bool all = false);

 private:
  static constexpr int kSlots = gpu::FrameRing::kSlots;
  static constexpr std::size_t kTextures = 64;  // largest number of textures in a frame; the first texture is the font

  struct Texture {
    VkImageView view;
    int layer;  // layer of an array texture; negative: the font, a texture that contains only coverage (opacity)
    std::uint64_t shows;
  };

  void draw(VkCommandBuffer commands, const ImDrawData& lists, const display::Target& target, std::size_t slot,
            const std::vector<display::Part>& parts);

  gpu::Device& device_;
  gpu::Image font_;
  VkSampler sampler_ = VK_NULL_HANDLE;
  gpu::ShaderInputs inputs_;  // shader inputs; each slot (frame in flight) has its own descriptor set for each texture
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  std::array<gpu::Buffer, kSlots> vertices_, indices_;
  std::vector<Texture> textures_;
  // for each target image: one hash per tile, of the content that was drawn last
  std::map<VkImage, std::vector<std::uint64_t>> holds_;
};

}  // namespace typodont

// The render targets: the eyes' pictures and their depth, and the begin and end of each pass that draws into them. The
// device and the quality determine which images exist and how samples are averaged.
#pragma once

#include <span>
#include <vector>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

class Targets {
 public:
  explicit Targets(PassContext& context) : context_(context) {}

  gpu::Image pictures;  // the renderer's result, one layer per eye
  std::vector<gpu::Image>
      kept_depth;  // one image of two layers if one pass draws both eyes, otherwise one per eye; only if depth is kept

  /// Creates images of the frame's size times the quality's scale, and sets the context's samples and view mask.
  void create(const glm::ivec2& frame_size, int views);
  void destroy();
  /// If true, the next create() keeps the scene's depth beside the pictures.
  bool keeps_depth = false;

  /// Returns true if the scene without particles is stored in its own image. Particles change nearly the whole picture
  /// in every frame. Copying a pixel of the stored scene is then much cheaper than drawing the pixel again. Returns
  /// false if samples are averaged, if one pass draws both eyes, or if the depth is kept.
  bool layered() const { return context_.samples == 1 && !context_.view_mask && !keeps_depth; }
  /// Returns the image into which the scene is drawn.
  const gpu::Image& scene() const { return layered() ? scene_ : pictures; }

  /// Call begin() before, and end() after the passes that draw a picture (the scene or the mouth mirror's picture).
  /// `partly`: true if only parts of the picture are drawn; all other parts keep their content.
  void begin(VkCommandBuffer commands, const gpu::Image& target, bool partly);
  void end(VkCommandBuffer commands, const gpu::Image& target);
  /// Begins the pass of one eye, or of both eyes if the device draws them in one pass. Only `box` of the picture is
  /// drawn.
  void begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                   const PixelBox& box, bool partly, const glm::vec3& clear);
  /// Ends the pass. `drawn`: the parts of the picture that were drawn and whose samples must still be averaged.
  void end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn);

  /// Stores the scene's new depth, and copies the `restored` parts of the scene into the pictures. Must be called after
  /// the scene is drawn, and only if layered(). Passes between begin_over() and end_over() then draw over these parts.
  void restore_scene(VkCommandBuffer commands, int views, bool partly, const EyeBoxes& drawn, const EyeBoxes& restored);
  void begin_over(VkCommandBuffer commands, const Frame& frame, int view);
  void end_over(VkCommandBuffer commands);

 private:
  PassContext& context_;
  gpu::Image color_, depth_;
  gpu::Image scene_, scene_depth_;  // if layered() is true: pictures and depth of the scene without particles

  /// Returns true if the samples of a pixel are averaged at the end of the pass. This is the case if one pass draws
  /// both eyes. If each eye has its own pass, a separate command averages the samples. The reason is an error of
  /// lavapipe 22.3: at the end of a pass, lavapipe always writes the averages into the first layer, even if the pass
  /// specifies another layer.
  bool resolves_in_pass() const { return context_.samples > 1 && context_.view_mask != 0; }
  bool resolves_by_command() const { return context_.samples > 1 && context_.view_mask == 0; }
};

}  // namespace typodont::render

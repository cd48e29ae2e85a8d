// Pictures and depth of both eyes, and begin and end of the passes that draw into them. Device and quality decide which
// images exist.
#pragma once

#include <span>
#include <vector>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

class Targets {
 public:
  explicit Targets(PassContext& context) : context_(context) {}

  gpu::Image pictures;                 // the renderer's result, one layer per eye
  std::vector<gpu::Image> kept_depth;  // if depth is kept: two layers for one common pass, or one image per eye

  /// Creates the images: frame size × the scale. Sets samples and view mask.
  void create(const glm::ivec2& frame_size, int views);
  void destroy();
  /// True: the next create() also creates `kept_depth`, in which the depth of the pictures is stored.
  bool keeps_depth = false;

  /// Returns true if the scene without particles has its own image: particles change nearly all pixels, and a copy of
  /// this image is cheaper than drawing the scene. Not with multisampling, one pass for both eyes, or kept depth.
  bool layered() const { return context_.samples == 1 && !context_.view_mask && !keeps_depth; }
  /// Image into which the scene is drawn.
  const gpu::Image& scene() const { return layered() ? scene_ : pictures; }

  /// Call begin() before all passes of a picture, end() after them. `partly`: undrawn parts keep their content.
  void begin(VkCommandBuffer commands, const gpu::Image& target, bool partly);
  void end(VkCommandBuffer commands, const gpu::Image& target);
  /// Begins the scene pass of one eye, or of both in a common pass; draws only in `box`.
  void begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                   const PixelBox& box, bool partly, const glm::vec3& clear);
  /// Ends the pass. `drawn`: parts whose samples need averaging.
  void end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn);

  /// Call after drawing the scene, if layered(). Copies the scene's parts `restored` into `pictures`; if `partly`, also
  /// stores the depth of the parts `drawn`. Later passes, from begin_over() to end_over(), draw over the scene.
  void restore_scene(VkCommandBuffer commands, int views, bool partly, const EyeBoxes& drawn, const EyeBoxes& restored);
  void begin_over(VkCommandBuffer commands, const Frame& frame, int view);
  void end_over(VkCommandBuffer commands);

 private:
  PassContext& context_;
  gpu::Image color_, depth_;
  gpu::Image scene_, scene_depth_;  // if layered(): colour and depth of the scene without particles

  /// Samples are averaged in the pass only if both eyes share it. With one pass per eye, a command averages them,
  /// because lavapipe 22.3 always writes the averages to the first layer.
  bool resolves_in_pass() const { return context_.samples > 1 && context_.view_mask != 0; }
  bool resolves_by_command() const { return context_.samples > 1 && context_.view_mask == 0; }
};

}  // namespace typodont::render

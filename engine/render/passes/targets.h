// The eyes' pictures and depth, and begin and end of passes into them. Device and quality decide which images exist.
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
  std::vector<gpu::Image> kept_depth;  // if kept: two layers for one pass, or one image per eye

  /// The frame's size times the scale; sets samples and view mask.
  void create(const glm::ivec2& frame_size, int views);
  void destroy();
  /// for the next create()
  bool keeps_depth = false;

  /// The scene without particles has its own image: they change nearly all pixels, and copying is cheaper than drawing.
  /// Not with averaged samples, one pass for both eyes, or kept depth.
  bool layered() const { return context_.samples == 1 && !context_.view_mask && !keeps_depth; }
  /// Where the scene is drawn.
  const gpu::Image& scene() const { return layered() ? scene_ : pictures; }

  /// Around the passes of a picture. `partly`: the rest keeps its content.
  void begin(VkCommandBuffer commands, const gpu::Image& target, bool partly);
  void end(VkCommandBuffer commands, const gpu::Image& target);
  /// One eye, or both in one pass; only `box`.
  void begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                   const PixelBox& box, bool partly, const glm::vec3& clear);
  /// `drawn`: parts whose samples must still be averaged.
  void end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn);

  /// After the scene, if layered(): stores its depth, copies `restored` parts into the pictures. Passes between
  /// begin_over() and end_over() draw over them.
  void restore_scene(VkCommandBuffer commands, int views, bool partly, const EyeBoxes& drawn, const EyeBoxes& restored);
  void begin_over(VkCommandBuffer commands, const Frame& frame, int view);
  void end_over(VkCommandBuffer commands);

 private:
  PassContext& context_;
  gpu::Image color_, depth_;
  gpu::Image scene_, scene_depth_;  // if layered(): without particles

  /// Only if one pass draws both eyes. Per eye, a command averages: lavapipe 22.3 always writes the averages into the
  /// first layer.
  bool resolves_in_pass() const { return context_.samples > 1 && context_.view_mask != 0; }
  bool resolves_by_command() const { return context_.samples > 1 && context_.view_mask == 0; }
};

}  // namespace typodont::render

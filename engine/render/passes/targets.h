// What the passes draw into: the eyes' pictures with their depth, and how a pass on them is opened and closed. Which
// images there are, and who averages samples, follows from the device and the quality.
#pragma once

#include <span>
#include <vector>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

class Targets {
 public:
  explicit Targets(PassContext& context) : context_(context) {}

  gpu::Image pictures;  // a layer per eye: what the renderer is for
  std::vector<gpu::Image>
      kept_depth;  // where it is kept: one of two layers where one pass draws both eyes, else one an eye

  /// Of a frame's size times the quality's scale; settles the context's samples and view mask.
  void create(const glm::ivec2& frame_size, int views);
  void destroy();
  /// From the next create() on: how far the scene is stays beside the pictures.
  bool keeps_depth = false;

  /// The scene is kept apart from the chips that fly before it: they change nearly all of the
  /// picture in every frame, and restoring a pixel costs a copy, drawing it anew triangles and light. Where samples are
  /// averaged, or one pass draws both eyes, all goes into one picture.
  bool layered() const { return context_.samples == 1 && !context_.view_mask && !keeps_depth; }
  /// What the scene is drawn into.
  const gpu::Image& scene() const { return layered() ? scene_ : pictures; }

  /// Before and after the passes of a picture: the scene's, or the mouth mirror's. `partly`: over what it holds.
  void begin(VkCommandBuffer commands, const gpu::Image& target, bool partly);
  void end(VkCommandBuffer commands, const gpu::Image& target);
  /// Opens the pass of one eye, or of both where the device draws them in one; `box` of it is drawn.
  void begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                   const PixelBox& box, bool partly, const glm::vec3& clear);
  /// `drawn`: what of the picture was, where its samples are yet to be averaged.
  void end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn);

  /// Where layered(), once the scene is drawn: its new parts join what was kept of its depth, and `restored` of it
  /// comes into the pictures, ready to be drawn over by passes opened with begin_over(); end_over() after the last of
  /// them.
  void restore_scene(VkCommandBuffer commands, int views, bool partly, const EyeBoxes& drawn, const EyeBoxes& restored);
  void begin_over(VkCommandBuffer commands, const Frame& frame, int view);
  void end_over(VkCommandBuffer commands);

 private:
  PassContext& context_;
  gpu::Image color_, depth_;
  gpu::Image scene_, scene_depth_;  // where layered(): the pictures without what lies over the scene, and how far it is

  /// Samples are averaged at the end of the pass where one pass draws both eyes, by a command of its own where each eye
  /// has its pass: lavapipe 22.3 averages into the first layer whatever layer the pass names, and says nothing.
  bool resolves_in_pass() const { return context_.samples > 1 && context_.view_mask != 0; }
  bool resolves_by_command() const { return context_.samples > 1 && context_.view_mask == 0; }
};

}  // namespace typodont::render

// The rendering passes; each is in its own file. A pass creates its pipeline at its first use.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "engine/render/passes/bricks.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

/// Draws the shadow map: the depth of the tissue as seen from the lamp. Redrawn only if tissue or lamp changed.
struct ShadowPass {
  gpu::Image map;
  VkPipeline pipeline = VK_NULL_HANDLE;
  /// Redraws the given part of the shadow map; the other parts keep their content.
  void record(PassContext& context, VkCommandBuffer commands, VkDescriptorSet set, BrickStore& bricks, int slot,
              View view, const glm::mat4& light_from_world, const ShadowMapBox& part, FrameStats& stats);
  void create_map(PassContext& context);  // sets the new map to the largest depth, which means no shadow
  void destroy(gpu::Device& device);
};

/// Effects on tissue that only some scenes and quality levels need.
struct SurfaceEffects {
  bool handpiece_shadow = false;
  bool spot = false;        // true: the border of the lamp's spot is drawn
  bool film = false;        // true: water and slurry on the surface are drawn
  bool light_grid = false;  // true: light from the room and from other surfaces is read from a grid
  bool operator==(const SurfaceEffects&) const = default;
};

/// Draws tissue: first the solid bodies; then, over the background, the bodies that the view draws as glass.
struct SurfacePass {
  std::array<VkPipeline, kBrickKinds> solid{};  // one pipeline for each kind of brick that has been drawn
  VkPipeline glass_pipeline = VK_NULL_HANDLE;
  View made_for = View::kLook;  // view for which the pipelines were created
  bool with_cursor = false;     // true if the pipelines were created with code that draws the cursor's ring
  SurfaceEffects with_effects;
  void record(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot, const SlotBuffers& indirect,
              std::span<const DrawGroup> groups, const Frame& frame, const SurfaceEffects& effects, bool glass,
              FrameStats& stats);
  int pipelines() const {
    return static_cast<int>(kBrickKinds -
                            static_cast<std::size_t>(std::count(solid.begin(), solid.end(), VkPipeline{}))) +
           (glass_pipeline ? 1 : 0);
  }
  void destroy(gpu::Device& device) {
    for (VkPipeline& p : solid) destroy_pipeline(device, p);
    destroy_pipeline(device, glass_pipeline);
  }
};

/// Triangles on the GPU, whose vertices have the format of the pipeline that draws them.
struct IndexedMesh {
  gpu::Buffer vertices, indices;
  std::uint32_t index_count = 0;  // 0: empty
  void set(gpu::Device& device, std::span<const std::byte> vertex_bytes, std::span<const std::uint32_t> new_indices);
  void draw(VkCommandBuffer commands, FrameStats& stats) const;
  void destroy(gpu::Device& device);
};

/// A tool's mesh on the GPU.
struct ToolBody {
  IndexedMesh mesh;
  int blades = 1;                                           // number of blades, see ToolMesh::blades
  double head_radius = 0, shank_radius = 0, shank_end = 0;  // m, tool dimensions for the shadow
  /// A section of the tool along its axis, in the tool's frame: a cylinder that contains the section at every spindle
  /// angle.
  struct Slice {
    float low = 0, high = 0, radius = 0;  // m, lower and upper end of the slice along the tool's axis, and radius
  };
  std::array<Slice, 8> slices{};
  void set(gpu::Device& device, const ToolMesh& shape);
};

/// A handpiece's mesh on the GPU.
struct HandpieceBody {
  IndexedMesh mesh;               // empty: there is no handpiece
  RoundCone head, body;           // shape that casts the handpiece's shadow, in frame H of the handpiece
  std::vector<BoxInWorld> boxes;  // boxes that contain the handpiece's triangles, in frame H of the handpiece
  void set(gpu::Device& device, const HandpieceMesh& shape);
};

struct ToolPass {
  VkPipeline pipeline = VK_NULL_HANDLE, handpiece_pipeline = VK_NULL_HANDLE;
  bool with_light_grid = false;  // value of SurfaceEffects::light_grid for which the first pipeline was created
  void record(PassContext& context, VkCommandBuffer commands, const ToolBody& body, const Pose& X_WB, bool light_grid,
              FrameStats& stats);
  void record_handpiece(PassContext& context, VkCommandBuffer commands, const HandpieceBody& body, const Pose& X_WH,
                        FrameStats& stats);
  void destroy(gpu::Device& device) {
    destroy_pipeline(device, pipeline);
    destroy_pipeline(device, handpiece_pipeline);
  }
};

/// Draws the mouth mirror. Its glass shows a picture of the reflected scene, which the other passes drew before.
struct MirrorPass {
  static constexpr std::uint32_t kGlassCorners = 96;  // number of corners of the drawn glass, as in mirror.vert
  VkPipeline pipeline = VK_NULL_HANDLE;
  gpu::Image picture;  // the reflected scene, one layer per eye; created when the glass first comes into view
  ToolBody body;
  double diameter = 0;  // m, diameter for which the body was created
  void prepare(gpu::Device& device, double wanted);
  void create_picture(PassContext& context, VkExtent2D size, std::uint32_t layers);
  void record_glass(PassContext& context, VkCommandBuffer commands, const MouthMirror& mirror, FrameStats& stats);
  void destroy_pictures(gpu::Device& device);  // destroys the pictures and all objects that depend on their format
  void destroy(gpu::Device& device);
};

struct BackgroundPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  void record(PassContext& context, VkCommandBuffer commands, FrameStats& stats);
  void destroy(gpu::Device& device) { destroy_pipeline(device, pipeline); }
};

struct ParticlePass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipeline cloud_pipeline = VK_NULL_HANDLE;  // draws particles that are stored on the GPU
  VkPipeline streak_pipeline = VK_NULL_HANDLE;
  SlotBuffers corners, streak_corners;
  std::uint32_t count = 0, streaks = 0;  // numbers of particles without and with a streak
  void prepare(PassContext& context, int slot, std::span<const Particle> particles);
  /// Marks the tiles (squares of the picture) that show particles.
  static void mark(std::span<const Particle> particles, const glm::dmat4& clip_from_world, const glm::ivec2& size,
                   Tiles& tiles);
  void record(PassContext& context, VkCommandBuffer commands, int slot, const ParticleCloud* cloud, FrameStats& stats);
  void destroy(gpu::Device& device);
};

/// Draws the area that the user cannot see (behind a headset's lenses) before all other parts and at the nearest depth,
/// so that the depth test rejects everything else in this area.
struct HiddenPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  gpu::Buffer corners;
  std::uint32_t count = 0;
  void set(gpu::Device& device, std::span<const glm::vec3> triangles);
  void record(PassContext& context, VkCommandBuffer commands, FrameStats& stats);
  void destroy(gpu::Device& device);
};

/// Masks the parts of the pictures that this frame does not redraw. It is drawn first and writes only depth, with the
/// nearest value, so that the depth test rejects everything else in these parts.
struct MaskPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  SlotBuffers corners;
  std::array<std::uint32_t, 2> first{}, count{};  // range of the mask's vertices for each eye
  void prepare(PassContext& context, int slot, const glm::ivec2& size, const EyeBoxes& kept);
  void record(PassContext& context, VkCommandBuffer commands, int slot, int view, FrameStats& stats);
  void destroy(gpu::Device& device);
};

}  // namespace typodont::render

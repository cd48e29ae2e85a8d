// The rendering passes, each in its own file. Pipelines are created at their first use, or before it by
// Renderer::prepare(). The functions options() describe them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/render/passes/bricks.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

/// Shadow map: depth seen from the lamp. Redrawn after a change of tissue or lamp.
struct ShadowPass {
  gpu::Image map;
  VkPipeline pipeline = VK_NULL_HANDLE;
  static gpu::PipelineOptions options(const PassContext& context);
  /// Draws the given part of the map; other parts stay.
  void record(PassContext& context, VkCommandBuffer commands, VkDescriptorSet set, BrickStore& bricks, int slot,
              View view, const glm::mat4& light_from_world, const ShadowMapBox& part, FrameStats& stats);
  void create_map(PassContext& context);  // clears the map to the largest depth, which means no shadow
  void destroy(gpu::Device& device);
};

/// The view, and effects that only some scenes and quality levels need.
struct SurfaceEffects {
  View view = View::kLook;
  bool cursor = false;  // true: draws the cursor's ring
  bool handpiece_shadow = false;
  bool spot = false;        // true: draws the border of the lamp's spot
  bool film = false;        // true: draws water and slurry on the tissue
  bool light_grid = false;  // true: light of the room and of other surfaces is in a LightGrid
  bool operator==(const SurfaceEffects&) const = default;
};

/// Draws solid bodies, then, over the background, bodies that are drawn as glass.
struct SurfacePass {
  std::array<VkPipeline, kBrickKinds> solid{};  // one per kind of brick, created when first drawn
  VkPipeline glass_pipeline = VK_NULL_HANDLE;
  std::array<VkPipeline, 2> depth{};  // pipelines that draw only depth: of front faces; of all faces
  SurfaceEffects made_for;            // the pipelines were created for this view and these effects
  /// Adds the options of all pipelines that record() may use.
  static void list_pipelines(const PassContext& context, const BrickStore& bricks, const SurfaceEffects& effects,
                             std::vector<gpu::PipelineOptions>& out);
  void record(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot, const SlotBuffers& indirect,
              std::span<const DrawGroup> groups, const SurfaceEffects& effects, bool glass, FrameStats& stats);
  /// Draws only the depth, so that no hidden point is shaded.
  void record_depth(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot,
                    const SlotBuffers& indirect, std::span<const DrawGroup> wanted);
  int pipelines() const {
    return static_cast<int>(kBrickKinds -
                            static_cast<std::size_t>(std::count(solid.begin(), solid.end(), VkPipeline{}))) +
           (glass_pipeline ? 1 : 0) + (depth[0] ? 1 : 0) + (depth[1] ? 1 : 0);
  }
  /// Call after a change of the pipelines' options.
  void forget_pipelines() {
    solid = {};
    depth = {};
    glass_pipeline = VK_NULL_HANDLE;
  }

 private:
  static gpu::PipelineOptions options(const PassContext& context, const SurfaceEffects& effects, BrickKind kind,
                                      bool glass);
  static gpu::PipelineOptions depth_options(const PassContext& context, bool both_sides);
  /// True: solid bricks are drawn to the depth picture first.
  static bool needs_depth(const PassContext& context, View view);
};

/// A mesh on the GPU; its vertices have the format of their pipeline.
struct IndexedMesh {
  gpu::Buffer vertices, indices;
  std::uint32_t index_count = 0;  // 0: empty
  void set(gpu::Device& device, std::span<const std::byte> vertex_bytes, std::span<const std::uint32_t> new_indices);
  void draw(VkCommandBuffer commands, FrameStats& stats) const;
  void destroy(gpu::Device& device);
};

/// Mesh of a tool on the GPU.
struct ToolBody {
  IndexedMesh mesh;
  int blades = 1;                                           // number of blades, see ToolMesh::blades
  double head_radius = 0, shank_radius = 0, shank_end = 0;  // m, tool dimensions for the shadow
  /// A cylinder that contains one slice of the tool at every spindle angle, in the tool's frame.
  struct Slice {
    float low = 0, high = 0, radius = 0;  // m, begin and end along the axis, and radius
  };
  std::array<Slice, 8> slices{};
  void set(gpu::Device& device, const ToolMesh& shape);
};

/// Mesh of a handpiece on the GPU.
struct HandpieceBody {
  IndexedMesh mesh;               // empty: there is no handpiece
  RoundCone head, body;           // shapes that cast the handpiece's shadow, frame H
  std::vector<BoxInWorld> boxes;  // boxes around the handpiece's triangles, frame H
  void set(gpu::Device& device, const HandpieceMesh& shape);
};

struct ToolPass {
  VkPipeline pipeline = VK_NULL_HANDLE, handpiece_pipeline = VK_NULL_HANDLE;
  bool with_light_grid = false;  // true: `pipeline` was created with SurfaceEffects::light_grid
  static gpu::PipelineOptions options(const PassContext& context, bool light_grid);
  static gpu::PipelineOptions handpiece_options(const PassContext& context);
  void record(PassContext& context, VkCommandBuffer commands, const ToolBody& body, const Pose& X_WB, bool light_grid,
              FrameStats& stats);
  void record_handpiece(PassContext& context, VkCommandBuffer commands, const HandpieceBody& body, const Pose& X_WH,
                        FrameStats& stats);
};

/// Draws the mouth mirror. Its glass shows the reflected scene, which was drawn before.
struct MirrorPass {
  static constexpr std::uint32_t kGlassCorners = 96;  // as in mirror.vert
  VkPipeline pipeline = VK_NULL_HANDLE;
  gpu::Image picture;  // picture in the mirror, one layer per eye; created when first seen
  ToolBody body;
  double diameter = 0;                                              // m, diameter for which the body was created
  static gpu::PipelineOptions options(const PassContext& context);  // of the glass
  void prepare(gpu::Device& device, double wanted);
  void create_picture(PassContext& context, VkExtent2D size, std::uint32_t layers);
  void record_glass(PassContext& context, VkCommandBuffer commands, const MouthMirror& mirror, FrameStats& stats);
  void destroy_pictures(gpu::Device& device);  // also destroys the objects that depend on the pictures' format
  void destroy(gpu::Device& device);
};

struct BackgroundPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  static gpu::PipelineOptions options(const PassContext& context);
  void record(PassContext& context, VkCommandBuffer commands, FrameStats& stats);
};

struct ParticlePass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipeline cloud_pipeline = VK_NULL_HANDLE;  // draws particles that are stored on the GPU
  VkPipeline streak_pipeline = VK_NULL_HANDLE;
  SlotBuffers corners, streak_corners;
  std::uint32_t count = 0, streaks = 0;  // numbers of particles without and with a streak
  /// `corners_given`: true for particles of a frame, false for those of a ParticleCloud.
  static gpu::PipelineOptions options(const PassContext& context, bool corners_given);
  static gpu::PipelineOptions streak_options(const PassContext& context);
  void prepare(PassContext& context, int slot, std::span<const Particle> particles);
  /// Marks the tiles in which particles are drawn.
  static void mark(std::span<const Particle> particles, const glm::dmat4& clip_from_world, const glm::ivec2& size,
                   Tiles& tiles);
  void record(PassContext& context, VkCommandBuffer commands, int slot, const ParticleCloud* cloud, FrameStats& stats);
  void destroy(gpu::Device& device);
};

/// Draws the parts of the picture that a headset's lenses hide. They are drawn first, at the nearest depth, so that the
/// depth test rejects everything else there.
struct HiddenPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  gpu::Buffer corners;
  std::uint32_t count = 0;
  static gpu::PipelineOptions options(const PassContext& context);
  void set(gpu::Device& device, std::span<const glm::vec3> triangles);
  void record(PassContext& context, VkCommandBuffer commands, FrameStats& stats);
  void destroy(gpu::Device& device);
};

/// Masks the parts that this frame does not redraw. The mask is drawn first, at the nearest depth, without colour, so
/// that the depth test rejects everything else there.
struct MaskPass {
  VkPipeline pipeline = VK_NULL_HANDLE;
  SlotBuffers corners;
  std::array<std::uint32_t, 2> first{}, count{};  // vertices of the mask, for each eye: index of the first, number
  static gpu::PipelineOptions options(const PassContext& context);
  void prepare(PassContext& context, int slot, const glm::ivec2& size, const EyeBoxes& kept);
  void record(PassContext& context, VkCommandBuffer commands, int slot, int view, FrameStats& stats);
  void destroy(gpu::Device& device);
};

}  // namespace typodont::render

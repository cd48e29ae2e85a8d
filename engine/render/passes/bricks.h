// All bodies made of bricks (blocks of triangles): their GPU memory, the selection of visible bricks, and their draw
// commands.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <unordered_map>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

/// A vertex as the GPU reads it: 24 bytes.
struct GpuVertex {
  float p[3];         // m, position relative to the mesh's origin
  std::int16_t n[4];  // unit normal; w: difference / kDifferenceRange; all as snorm
  // Byte 0: the first tissue (low four bits) and Vertex::cut · 15 (high four bits). Byte 1: the second tissue and
  // Vertex::thin · 15. Byte 2: the second tissue's fraction · 255. Byte 3: the tissue below the surface and the visible
  // fraction of its colour · 15.
  std::uint8_t tissue[4];
};
static_assert(sizeof(GpuVertex) == 24);
inline constexpr float kDifferenceRange = 2e-3f;  // m, limit to which |Vertex::difference| is clamped when it is stored

/// Content of a brick (block of triangles); it selects the shader for its pixels.
enum class BrickKind : std::uint8_t { kAny, kGum, kEnamel, kSound, kTwoSided, kMetal };
inline constexpr std::size_t kBrickKinds = 6;
/// Returns the shader constant kHolds for a kind of brick: one bit for each kind of content (frame.glsl).
constexpr std::uint32_t holds(BrickKind kind) {
  constexpr std::array<std::uint32_t, kBrickKinds> kBits{15, 8, 4, 5, 31, 47};
  return kBits[static_cast<std::size_t>(kind)];
}

struct Brick {
  int block = -1;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first_vertex = 0, vertices = 0, first_index = 0, indices = 0;
  glm::vec3 lo{0}, hi{0};  // m, corners of the bounding box in the mesh's frame
  glm::vec3 cone_axis{0, 0, 1};
  // sine of the largest angle between a normal and the cone's axis; 1: normals in all directions
  float cone_cutoff = 1;
  bool first = false;            // true if the brick (block of triangles) exists since the start and has not changed
  std::array<PixelBox, 2> seen;  // box of the brick's pixels in each eye's picture
  std::uint64_t seen_by = 0;     // version of the eyes' poses for which `seen` is valid
};

struct Mesh {
  Pose X_WM;
  std::unordered_map<std::uint64_t, Brick> bricks;
};

struct BrickBlock {
  gpu::Buffer vertices, indices;
  gpu::RangeAllocator free_vertices, free_indices;
};

/// Draw commands for the bricks of one mesh in one memory block.
struct DrawGroup {
  MeshId mesh = 0;
  int block = 0;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first = 0, count = 0;  // range of the group's commands in the indirect buffer
};

/// shown_in() returns true if the view draws the mesh. glassy_in() returns true if the view draws the mesh as glass.
bool shown_in(View view, MeshId mesh);
bool glassy_in(View view, MeshId mesh);

/// Bounds of the working tooth (lo, hi) and of all bodies (all_lo, all_hi), in m, frame W. If there is no working
/// tooth, lo and hi are the bounds of all bodies, too.
struct SceneBounds {
  glm::dvec3 lo, hi, all_lo, all_hi;
};

struct BrickStore {
  std::map<MeshId, Mesh> meshes;
  // for each mesh: a plane; bricks (blocks of triangles) that the mesh had at the start and that lie beyond this plane
  // are inside another body (Renderer::cover)
  std::map<MeshId, glm::dvec4> covers;
  std::vector<BrickBlock> blocks;
  SlotBuffers indirect, shadow_indirect, mirror_indirect;
  std::uint64_t version = 1;  // version of all bricks; increases with every change
  // version of the bodies' poses and planes; increases when a body is placed, removed or covered
  std::uint64_t order = 1;
  std::vector<BoxInWorld> changed;  // old and new boxes of the bricks that changed since the last frame
  int uploaded = 0;                 // number of bricks (blocks of triangles) uploaded since the last frame
  std::uint64_t uploaded_bytes = 0;

  void update(gpu::Device& device, MeshId mesh, std::span<const MeshUpdate> updates, std::uint64_t frame);
  void remove(MeshId mesh, std::uint64_t frame);
  /// Frees the memory of bricks (blocks of triangles) that no unfinished frame draws any more.
  void collect(std::uint64_t finished);

  /// Returns the bounds of the scene; no value if there are no bricks (blocks of triangles).
  std::optional<SceneBounds> bounds() const;
  /// Returns draw commands for the bricks (blocks of triangles) in an eye's view. The commands are written into the
  /// buffer of `into` for this slot (frame in flight); their counts are added to `stats`. `tiles`: for each eye the
  /// part of the picture to redraw; null: the whole picture.
  std::vector<DrawGroup> visible(gpu::Device& device, int slot, const Frame& frame, SlotBuffers& into,
                                 FrameStats& stats, const std::array<Tiles, 2>* tiles = nullptr);
  /// Marks the tiles (squares) whose content or lighting changed since the last frame because of changed bricks or of
  /// the tool. `data` contains the present tool, `before` the previous one. `eyes` is the version of the eyes' poses.
  void mark_changed(const Frame& frame, const shared::FrameData& data, const shared::FrameData& before,
                    const glm::ivec2& size, std::uint64_t eyes, std::array<Tiles, 2>& tiles);
  /// Returns draw commands for all bricks that the view shows and that lie in the given part of the shadow map.
  std::vector<DrawGroup> all(gpu::Device& device, int slot, View view, const glm::dmat4& light_from_world,
                             const ShadowMapBox& part);
  void draw(VkCommandBuffer commands, VkPipelineLayout layout, VkBuffer commands_buffer,
            std::span<const DrawGroup> groups) const;
  void destroy(gpu::Device& device);

 private:
  struct Retired {
    std::uint64_t frame;
    Brick brick;
  };
  std::deque<Retired> retired_;
  std::vector<GpuVertex> packed_;
  void retire(const Brick& brick, std::uint64_t frame);
};

}  // namespace typodont::render

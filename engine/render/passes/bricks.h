// Bodies that consist of bricks: GPU memory, visibility, draw commands.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <unordered_map>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

/// A vertex on the GPU, 28 bytes.
struct GpuVertex {
  float p[3];         // m, position relative to the mesh's origin
  std::int16_t n[4];  // xyz: unit normal; w: Vertex::difference / kDifferenceRange; signed normalised
  // Four bytes: first tissue and Vertex::cut · 15 (low and high four bits); second tissue and Vertex::thin · 15;
  // fraction of the second tissue · 255; tissue below and its visible fraction · 15.
  std::uint8_t tissue[4];
  std::uint8_t lesion[4];  // Vertex::lesion · 255; Vertex::paint as VoxelColor, low byte first, and its fraction · 255
};
static_assert(sizeof(GpuVertex) == 28);
inline constexpr float kDifferenceRange = 2e-3f;  // m, largest |Vertex::difference| that is stored

/// Kind of a brick by its content; selects the shader. kSound: hard tissue without caries.
enum class BrickKind : std::uint8_t { kAny, kGum, kEnamel, kSound, kTwoSided, kMetal };
inline constexpr std::size_t kBrickKinds = 6;
/// Value of the shader constant kHolds (frame.glsl): one bit per kind of content, such as kHoldsDecay.
constexpr std::uint32_t holds(BrickKind kind) {
  constexpr std::array<std::uint32_t, kBrickKinds> kBits{15, 8, 4, 5, 31, 47};
  return kBits[static_cast<std::size_t>(kind)];
}

struct Brick {
  int block = -1;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first_vertex = 0, vertices = 0, first_index = 0, indices = 0;
  glm::vec3 lo{0}, hi{0};  // m, corners of the brick's bounding box, in the mesh's frame
  glm::vec3 cone_axis{0, 0, 1};
  // Sine of the largest angle between a triangle's normal and the cone's axis; 1: normals in all directions.
  float cone_cutoff = 1;
  bool first = false;            // true: the brick has not changed since the start
  std::array<PixelBox, 2> seen;  // pixels that the brick covers, for each eye
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

/// Draw commands for one mesh's bricks in one memory block.
struct DrawGroup {
  MeshId mesh = 0;
  int block = 0;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first = 0, count = 0;  // index of the first command in the indirect buffer, and number of commands
};

/// Whether a mesh is drawn in a view, and whether it is drawn as glass.
bool shown_in(View view, MeshId mesh);
bool glassy_in(View view, MeshId mesh);

/// Bounding boxes, m, frame W. lo, hi: working tooth; if there is no tooth, all bodies. all_lo, all_hi: all bodies.
struct SceneBounds {
  glm::dvec3 lo, hi, all_lo, all_hi;
};

/// Kinds of bricks that a view draws, each with a pipeline of its own: solid, and as glass.
struct DrawnKinds {
  std::array<bool, kBrickKinds> solid{};
  bool glass = false;
};

struct BrickStore {
  std::map<MeshId, Mesh> meshes;
  // For each mesh: the plane that Renderer::cover() has set.
  std::map<MeshId, glm::dvec4> covers;
  std::vector<BrickBlock> blocks;
  SlotBuffers indirect, shadow_indirect, mirror_indirect;
  std::uint64_t version = 1;  // version of all bricks; increases with every change
  // A counter that increases when a body is placed, removed or covered.
  std::uint64_t order = 1;
  std::vector<BoxInWorld> changed;  // boxes of changed bricks before and after the change, since the last frame
  int uploaded = 0;                 // number of bricks uploaded since the last frame
  std::uint64_t uploaded_bytes = 0;

  void update(gpu::Device& device, MeshId mesh, std::span<const MeshUpdate> updates, std::uint64_t frame);
  void remove(MeshId mesh, std::uint64_t frame);
  /// Frees memory that no unfinished frame uses.
  void collect(std::uint64_t finished);

  /// Bounds of all bricks; nullopt without bricks.
  std::optional<SceneBounds> bounds() const;
  DrawnKinds drawn_kinds(View view) const;
  /// Draw commands for the bricks that an eye can see. `slot`: index of the frame in flight; `into`: receives the
  /// commands; `stats`: receives their number. `tiles`: parts to redraw for each eye; null: all.
  std::vector<DrawGroup> visible(gpu::Device& device, int slot, const Frame& frame, SlotBuffers& into,
                                 FrameStats& stats, const std::array<Tiles, 2>* tiles = nullptr);
  /// Marks tiles whose content or light has changed, because of bricks or the tool (`data`: this frame, `before`: last
  /// frame). `eyes`: version of the eyes' poses. Stops when kFullRedrawFraction of the tiles is marked.
  void mark_changed(const Frame& frame, const shared::FrameData& data, const shared::FrameData& before,
                    const glm::ivec2& size, std::uint64_t eyes, std::array<Tiles, 2>& tiles);
  /// Draw commands for all bricks in a part of the shadow map.
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

// All surfaces made of bricks: their places in GPU memory, what of them is in view, and the draw commands for that.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <unordered_map>

#include "engine/render/passes/changed.h"
#include "engine/render/passes/context.h"

namespace typodont::render {

/// As the GPU reads it: 24 bytes.
struct GpuVertex {
  float p[3];              // m, mesh
  std::int16_t n[4];       // snorm; w: difference, of kDifferenceRange
  std::uint8_t tissue[4];  // the two tissues, the second's share of 255; the tissue beneath and its share of 15
};
static_assert(sizeof(GpuVertex) == 24);
inline constexpr float kDifferenceRange = 2e-3f;  // m

/// What a brick holds decides which code its pixels need.
enum class BrickKind : std::uint8_t { kAny, kGum, kEnamel, kSound, kTwoSided };
inline constexpr std::size_t kBrickKinds = 5;
/// The bits of kHolds in frame.glsl.
constexpr std::uint32_t holds(BrickKind kind) {
  constexpr std::array<std::uint32_t, kBrickKinds> kBits{15, 8, 4, 5, 31};
  return kBits[static_cast<std::size_t>(kind)];
}

struct Brick {
  int block = -1;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first_vertex = 0, vertices = 0, first_index = 0, indices = 0;
  glm::vec3 lo{0}, hi{0};  // m, mesh
  glm::vec3 cone_axis{0, 0, 1};
  float cone_cutoff = 1;         // sine of the normals' spread about the axis; 1: they point everywhere
  bool first = false;            // it was there from the start and has not changed since
  std::array<PixelBox, 2> seen;  // where each eye of BrickStore::eyes has it
  std::uint64_t seen_by = 0;     // which eyes those were
};

struct Mesh {
  Pose X_WM;
  std::unordered_map<std::uint64_t, Brick> bricks;
};

struct BrickBlock {
  gpu::Buffer vertices, indices;
  gpu::RangeAllocator free_vertices, free_indices;
};

/// Draws of one block of one mesh.
struct DrawGroup {
  MeshId mesh = 0;
  int block = 0;
  BrickKind kind = BrickKind::kAny;
  std::uint32_t first = 0, count = 0;  // in the indirect buffer
};

/// What a view draws, and of that what it draws as glass.
bool shown_in(View view, MeshId mesh);
bool glassy_in(View view, MeshId mesh);

/// m, W: of the working tooth (of everything where there is none) and of everything.
struct SceneBounds {
  glm::dvec3 lo, hi, all_lo, all_hi;
};

struct BrickStore {
  std::map<MeshId, Mesh> meshes;
  std::map<MeshId, glm::dvec4> covers;  // where a mesh's first bricks lie within another body (Renderer::cover)
  std::vector<BrickBlock> blocks;
  SlotBuffers indirect, shadow_indirect, mirror_indirect;
  std::uint64_t version = 1;        // rises with every change
  std::uint64_t order = 1;          // rises when more than bricks changed: bodies placed, removed, covered
  std::vector<BoxInWorld> changed;  // where bricks were and are that changed since the last frame
  int uploaded = 0;                 // bricks since the last frame
  std::uint64_t uploaded_bytes = 0;

  void update(gpu::Device& device, MeshId mesh, std::span<const MeshUpdate> updates, std::uint64_t frame);
  void remove(MeshId mesh, std::uint64_t frame);
  /// Gives back the room of bricks that no unfinished frame draws any more.
  void collect(std::uint64_t finished);

  /// Nothing when there is nothing.
  std::optional<SceneBounds> bounds() const;
  /// Commands for the bricks some eye sees, written into this slot's buffer of `into`; counts into
  /// `stats`. `tiles`: of each eye's picture, what is drawn anew; null: all.
  std::vector<DrawGroup> visible(gpu::Device& device, int slot, const Frame& frame, SlotBuffers& into,
                                 FrameStats& stats, const std::array<Tiles, 2>* tiles = nullptr);
  /// Marks where the frame's eyes see what changed since the last frame, and all that is lit otherwise by it or by the
  /// tool: as `data` has the tool now and `before` had it. `eyes` numbers the eyes' places.
  void mark_changed(const Frame& frame, const shared::FrameData& data, const shared::FrameData& before,
                    const glm::ivec2& size, std::uint64_t eyes, std::array<Tiles, 2>& tiles);
  /// Commands for all bricks that the view shows and that lie in a part of the lamp's map.
  std::vector<DrawGroup> all(gpu::Device& device, int slot, View view, const glm::dmat4& light_from_world,
                             const LampBox& part);
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

// Bricks of distance field → triangles, only where bricks changed. One thread, the one that owns the bricks.
//
//   SurfaceMesher mesher({.tolerance = 0.1f});
//   for (brick that changed) mesher.put(brick);          // or remove(key) when the surface has left it
//   for (const glm::ivec3& key : mesher.remesh()) upload(*mesher.find(key));
//
// The triangles of all bricks together form a closed, oriented, 2-manifold surface without cracks: vertices on the
// border of two bricks are the same bits in both. The result depends on the bricks alone, not on the order or number of
// updates. Per-brick meshes are polygons of dual contouring: README.md says how.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::surface {

/// 28 bytes, as a vertex buffer takes it. The frame is that of the bricks' voxels: p_W = frame.to_world(position).
struct SurfaceVertex {
  glm::vec3 position{0};  // voxels
  glm::vec3 normal{0};    // unit, out of the tissue; on a crease that of this triangle's side
  // The same two tissues at all corners of a triangle; the boundary runs where the interpolated `second` passes 0.5, so
  // that a shader that switches there draws it crisp.
  Tissue tissue[2]{};       // [0] <= [1]
  std::uint8_t second = 0;  // 0..255: share of tissue[1]
  std::uint8_t unused = 0;
};
static_assert(sizeof(SurfaceVertex) == 28);

/// The triangles of one brick. Counter-clockwise seen from outside the tissue.
struct BrickMesh {
  glm::ivec3 key{0};
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
  /// Per vertex, the same number for copies of the same point, here and in other bricks (with `owner`): for welding.
  std::vector<std::uint16_t> point;
  std::vector<std::uint8_t> owner;  // bit a set: the point belongs to the brick one lower along axis a
  glm::vec3 low{0}, high{0};        // voxels, bounds of the vertices
  glm::vec3 cone_axis{0};           // mean normal
  float cone_cosine = -1;           // every triangle's normal lies within this of the axis; -1: all directions
};

struct MesherOptions {
  /// Voxels. Cells are merged while the mesh stays within this of the surface; 0 merges only what is flat, negative
  /// never merges.
  float tolerance = 0.1f;
};

class SurfaceMesher {
 public:
  explicit SurfaceMesher(const MesherOptions& options = {});
  ~SurfaceMesher();
  SurfaceMesher(SurfaceMesher&&) noexcept;
  SurfaceMesher& operator=(SurfaceMesher&&) noexcept;

  /// Of bricks put from now on. Bricks put with different tolerances join without cracks all the same.
  void set_tolerance(float tolerance);

  /// Takes a brick whose samples are new or have changed. Every brick whose 17³ cell corners have both signs must be
  /// put, and every brick whose 19³ samples changed must be put again, before remesh().
  void put(const FieldBrick& brick);
  /// Forgets a brick: as if it had been put without any surface in it.
  void remove(const glm::ivec3& key);

  /// Makes the triangles of all bricks touched since the last call. Returns their keys, sorted; a brick whose mesh is
  /// now empty is among them when it was not empty before. Valid until the next call of anything here.
  std::span<const glm::ivec3> remesh();

  /// nullptr where no surface passes. Valid until the next remesh().
  const BrickMesh* find(const glm::ivec3& key) const;
  /// Keys of all bricks with triangles, sorted.
  std::vector<glm::ivec3> keys() const;
  std::size_t triangle_count() const;
  /// Of every vertex and triangle of every brick: equal exactly when the meshes are.
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::surface

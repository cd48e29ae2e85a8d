// Bricks (16³ cells) of the distance field to triangles; only changed ones are updated. One thread.
//
//   SurfaceMesher mesher({.tolerance = 0.1f});
//   for (brick that changed) mesher.put(brick);          // or remove(key) when it holds no surface any more
//   for (const glm::ivec3& key : mesher.remesh()) upload(*mesher.find(key));
//
// Closed, oriented, 2-manifold, without cracks: border vertices have the same bits in both bricks, whatever the order
// of updates. Dual contouring (README.md).
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::surface {

/// 28 bytes, as in the vertex buffer. Voxel frame: p_W = frame.to_world(position).
struct SurfaceVertex {
  glm::vec3 position{0};  // voxels, position of the vertex
  glm::vec3 normal{0};    // outwards; on a crease of this triangle's side
  // All corners have the same two; the border is where `second` passes 0.5.
  Tissue tissue[2]{};       // the two tissues, in ascending order: [0] <= [1]
  std::uint8_t second = 0;  // 0..255: fraction of tissue[1] around the vertex
  std::uint8_t unused = 0;
};
static_assert(sizeof(SurfaceVertex) == 28);

/// Counter-clockwise from outside.
struct BrickMesh {
  glm::ivec3 key{0};
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
  /// With `owner`, the same for all copies of a point in all bricks.
  std::vector<std::uint16_t> point;
  std::vector<std::uint8_t> owner;  // bit a: of the next lower brick along a
};

struct MesherOptions {
  /// voxels of merging; 0: flat areas only; negative: none
  float tolerance = 0.1f;
};

class SurfaceMesher {
 public:
  explicit SurfaceMesher(const MesherOptions& options = {});
  ~SurfaceMesher();
  SurfaceMesher(SurfaceMesher&&) noexcept;
  SurfaceMesher& operator=(SurfaceMesher&&) noexcept;

  /// For bricks put from now on; differing ones join without cracks.
  void set_tolerance(float tolerance);

  /// After one of its 19³ samples changed. Before remesh(), every brick whose 17³ corners differ in sign.
  void put(const FieldBrick& brick);
  /// As a brick without surface.
  void remove(const glm::ivec3& key);

  /// Changed since the last call, sorted, with those now empty. Valid until the next call.
  std::span<const glm::ivec3> remesh();
  /// As remesh(), but each mesh goes to `visit` and is not kept. Do not mix both.
  void remesh(const std::function<void(const BrickMesh&)>& visit);

  // The following functions describe the meshes that remesh() keeps.
  /// Null: no surface. Valid until the next remesh().
  const BrickMesh* find(const glm::ivec3& key) const;
  /// With triangles, sorted.
  std::vector<glm::ivec3> keys() const;
  std::size_t triangle_count() const;
  /// Of all vertices and triangles.
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::surface

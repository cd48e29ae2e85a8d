// Converts bricks (16³ cells) of the distance field to triangles, and updates only changed bricks. One thread.
//
//   SurfaceMesher mesher({.tolerance = 0.1f});
//   for (brick that changed) mesher.put(brick);          // or remove(key) when it holds no surface any more
//   for (const glm::ivec3& key : mesher.remesh()) upload(*mesher.find(key));
//
// Dual contouring (README.md). The mesh is closed and 2-manifold, without cracks: vertices on the border of two bricks
// are bit-identical in both.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::surface {

/// Vertex of 28 bytes, as in the vertex buffer. Positions are in the voxel frame: p_W = frame.to_world(position).
struct SurfaceVertex {
  glm::vec3 position{0};  // voxels, position of the vertex
  glm::vec3 normal{0};    // unit normal, pointing outwards; on a crease, the normal of this triangle's side
  // All corners of a triangle have the same pair of tissues. The border between the two lies where `second` is 0.5.
  Tissue tissue[2]{};       // the two tissues, in ascending order: [0] <= [1]
  std::uint8_t second = 0;  // 0..255: fraction of tissue[1] around the vertex
  std::uint8_t unused = 0;
};
static_assert(sizeof(SurfaceVertex) == 28);

/// Mesh of one brick; triangles are counter-clockwise from outside.
struct BrickMesh {
  glm::ivec3 key{0};
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
  /// For each vertex: number of its point in the brick that owns it. All copies of a point have the same `point` and
  /// `owner` brick.
  std::vector<std::uint16_t> point;
  std::vector<std::uint8_t> owner;  // bit a is set if the next lower brick along axis a owns the point
};

struct MesherOptions {
  /// voxels, largest error of merged cells; 0: merges only flat areas; negative: never merges
  float tolerance = 0.1f;
};

class SurfaceMesher {
 public:
  explicit SurfaceMesher(const MesherOptions& options = {});
  ~SurfaceMesher();
  SurfaceMesher(SurfaceMesher&&) noexcept;
  SurfaceMesher& operator=(SurfaceMesher&&) noexcept;

  /// Sets the tolerance for bricks that put() receives from now on. Bricks of different tolerance join without cracks.
  void set_tolerance(float tolerance);

  /// Passes a brick's samples to the mesher. Call it when one of the brick's 19³ samples has changed. Before remesh(),
  /// it must have been called for every brick whose 17³ corners differ in sign.
  void put(const FieldBrick& brick);
  /// Tells the mesher that a brick has no surface any more; in place of put().
  void remove(const glm::ivec3& key);

  /// Meshes the changed bricks. Returns the sorted keys of all bricks that changed since the last call, also of those
  /// that are now empty. Valid until the next call.
  std::span<const glm::ivec3> remesh();
  /// Like remesh(), but passes each mesh to `visit` and does not keep it. Do not use both functions on one mesher.
  void remesh(const std::function<void(const BrickMesh&)>& visit);

  // The following functions describe the meshes that remesh() keeps.
  // Returns null if the brick has no surface. Valid until the next remesh().
  const BrickMesh* find(const glm::ivec3& key) const;
  /// Returns the sorted keys of all bricks with triangles.
  std::vector<glm::ivec3> keys() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::surface

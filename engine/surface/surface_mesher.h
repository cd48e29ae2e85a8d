// Converts bricks (blocks of 16³ cells) of the distance field to triangles, and updates only the bricks that changed.
// One thread owns the mesher and its bricks.
//
//   SurfaceMesher mesher({.tolerance = 0.1f});
//   for (brick that changed) mesher.put(brick);          // or remove(key) when it holds no surface any more
//   for (const glm::ivec3& key : mesher.remesh()) upload(*mesher.find(key));
//
// The triangles of all bricks together form a closed, oriented, 2-manifold surface without cracks: vertices on the
// border of two bricks have the same bits in both. The result depends only on the bricks, not on the order or number of
// updates. The polygons come from dual contouring (README.md).
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::surface {

/// A vertex in the layout of the vertex buffer, 28 bytes. Positions are in the voxel frame of the bricks (blocks of 16³
/// cells): p_W = frame.to_world(position).
struct SurfaceVertex {
  glm::vec3 position{0};  // voxels, position of the vertex
  glm::vec3 normal{0};    // unit normal, pointing out of the tissue; on a crease the normal of this triangle's side
  // The three corners of a triangle store the same two tissues. The boundary between the tissues lies where the
  // interpolated `second` passes 0.5. A shader that switches there draws a sharp boundary.
  Tissue tissue[2]{};       // the two tissues, in ascending order: [0] <= [1]
  std::uint8_t second = 0;  // 0..255: fraction of tissue[1] around the vertex
  std::uint8_t unused = 0;
};
static_assert(sizeof(SurfaceVertex) == 28);

/// The triangles of one brick (16³ cells), counter-clockwise as seen from outside the tissue.
struct BrickMesh {
  glm::ivec3 key{0};
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
  /// A number for each vertex. Together with `owner`, the number identifies the vertex's point: all copies of a point
  /// have the same number, in other bricks (blocks of 16³ cells) too. The number is used to merge vertices.
  std::vector<std::uint16_t> point;
  std::vector<std::uint8_t> owner;  // bit a is set if the point belongs to the next lower brick along axis a
};

struct MesherOptions {
  /// voxels, cells are merged if the mesh stays within this distance of the surface. 0: only flat areas are merged;
  /// negative: nothing is merged.
  float tolerance = 0.1f;
};

class SurfaceMesher {
 public:
  explicit SurfaceMesher(const MesherOptions& options = {});
  ~SurfaceMesher();
  SurfaceMesher(SurfaceMesher&&) noexcept;
  SurfaceMesher& operator=(SurfaceMesher&&) noexcept;

  /// Sets the tolerance for bricks (blocks of 16³ cells) that are put from now on. Bricks with different tolerances
  /// still join without cracks.
  void set_tolerance(float tolerance);

  /// Adds a brick (16³ cells), or replaces it after one of its 19³ samples has changed. Before remesh(), every brick
  /// that contains surface must have been put: every brick whose 17³ cell corners include both positive and negative
  /// values.
  void put(const FieldBrick& brick);
  /// Removes a brick (16³ cells). The effect is the same as putting a brick without surface.
  void remove(const glm::ivec3& key);

  /// Builds the triangles of all bricks (blocks of 16³ cells) that changed since the last call, and returns their keys,
  /// sorted. The keys include bricks whose mesh has become empty. The returned span is valid until the next call of any
  /// function of this class.
  std::span<const glm::ivec3> remesh();
  /// Builds the same meshes as remesh(), in the same order, but passes each mesh to `visit` and does not keep it, which
  /// saves memory and time. The mesh is valid during the call. Do not use both versions of remesh() with one mesher.
  void remesh(const std::function<void(const BrickMesh&)>& visit);

  // The following functions describe the meshes that remesh() keeps.
  /// Returns a brick's mesh; nullptr if the brick contains no surface. The pointer is valid until the next remesh().
  const BrickMesh* find(const glm::ivec3& key) const;
  /// Returns the keys of all bricks (blocks of 16³ cells) with triangles, sorted.
  std::vector<glm::ivec3> keys() const;
  std::size_t triangle_count() const;
  /// Returns one hash value of the whole mesh (all vertices and triangles of all bricks). Equal meshes have equal
  /// values.
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace typodont::surface

// The surface contact point (SCP): the proxy of the hand's point (HIP), which stays outside the mesh.
#pragma once

#include <array>
#include <span>

#include "haptics/contact/mesh_lod/plane_set.h"
#include "haptics/contact/mesh_lod/surface_contact.h"

namespace typodont::haptics::mesh_lod {

/// Stiffness of every tissue, N/m. A wall exists where the stiffness increases.
using Stiffness = PerTissue;

struct SurfaceOptions {
  double radius = 0;         // m, radius of the tool's end; 0: a point
  bool walls = true;         // one-sided walls at tissue borders
  double wall_limit = 0.5;   // N, force at which a wall yields
  double unit_force = 1000;  // N/m, stiffness of the coupling for a material stiffness of 1 N/mm
};

/// After Wang et al. 2009, section 3.2. The paper moves from the active primitive to its neighbours while the
/// distance to the HIP decreases. Here every face near the point bounds it by a plane through the face's nearest
/// primitive (vertex, edge or interior). The point moves to the position nearest to the HIP that satisfies these
/// planes, and iterates until it does not move. The result is the same, but no links between neighbours are needed;
/// such links do not exist at cracks, duplicate triangles and slivers. Since the planes bound convex obstacles, no
/// step can pass through a face of any mesh. The point is the centre of a ball with the tool's radius; a point tool
/// is a ball of radius `kSkin`. Servo thread; never allocates.
class SurfacePoint final : public SurfaceContact {
 public:
  static constexpr double kSkin = 1e-8;        // m, least distance of the point from a face
  static constexpr double kFarthest = 1.5e-3;  // m, largest allowed `most` of clearance()

  SurfacePoint(const SurfaceOptions& options, const Stiffness& stiffness) : options_(options), stiffness_(stiffness) {}

  double radius() const noexcept override { return options_.radius > kSkin ? options_.radius : kSkin; }
  double reach() const noexcept override { return radius(); }
  double outlook() const noexcept override { return radius() + kFarthest; }

  /// Begins at p. Returns false if p was inside the tissue, or closer to the tissue than the radius; then the point
  /// was moved out.
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept override;
  void put_free(const dvec3& p) noexcept override;
  void map_to(const TriangleGrid& grid) noexcept override;
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give = false) noexcept override;
  void mesh_changed() noexcept override { collected_ = nullptr; }
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept override;
  PerTissue engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept override;

 private:
  bool lift(const TriangleGrid& grid, dvec3 n) noexcept;
  void collect(const TriangleGrid& grid, double reach) noexcept;
  void round_edge(const TriangleGrid& grid, const dvec3& hip, const Plane& plane, dvec3& step) const noexcept;
  bool look(const TriangleGrid& grid, double reach, bool give) noexcept;
  std::span<const std::uint32_t> close_faces(const TriangleGrid& grid, double within) noexcept;
  void add_walls(const Face& face, std::uint32_t index, double reach, bool& room) noexcept;
  double stiffness_of(Tissue tissue) const noexcept { return stiffness_[static_cast<std::size_t>(tissue)]; }

  SurfaceOptions options_;
  Stiffness stiffness_;
  Tissue ground_ = Tissue::kAir;  // tissue in contact; air: no contact
  bool behind_ = false;  // a wall yielded: walls are ignored until the contact is on the harder tissue, `beyond_`
  Tissue beyond_ = Tissue::kAir;  // the harder tissue behind the wall that yielded
  // Faces near the position at which they were collected, with their boxes in structure-of-arrays form.
  static constexpr int kMostNear = 2048, kBatch = 8;
  struct Boxes {
    alignas(32) float lo_x[kMostNear + kBatch], lo_y[kMostNear + kBatch], lo_z[kMostNear + kBatch];
    alignas(32) float hi_x[kMostNear + kBatch], hi_y[kMostNear + kBatch], hi_z[kMostNear + kBatch];
  };
  std::array<std::uint32_t, kMostNear> near_{};
  int near_count_ = 0;
  Boxes boxes_{};
  const TriangleGrid* collected_ = nullptr;  // grid of the collected faces; null: they must be collected again
  // The faces used in one iteration, as indices in near_.
  std::array<std::uint32_t, kMostNear + kBatch> close_{};
  dvec3 near_from_{0};
  double near_reach_ = 0;
  // Faces whose nearest primitive in one iteration is an edge or a corner.
  struct Edge {
    std::uint32_t face = 0;
    OnFace at;
  };
  std::array<Edge, kMostNear> edges_;
  PlaneSet planes_;
  // Planes of the faces whose nearest primitive is their interior; they come first in the list. Arrays of the
  // normals, and of the distances from the centre.
  struct Inner {
    alignas(32) float x[PlaneSet::kMost], y[PlaneSet::kMost], z[PlaneSet::kMost], distance[PlaneSet::kMost];
  };
  Inner inner_{};
  std::array<std::uint32_t, PlaneSet::kMost> above_{};
};

}  // namespace typodont::haptics::mesh_lod

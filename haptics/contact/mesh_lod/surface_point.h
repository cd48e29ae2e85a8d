// The surface contact point (SCP): where the hand's point (HIP) is held outside the mesh.
#pragma once

#include <array>
#include <span>

#include "haptics/contact/mesh_lod/plane_set.h"
#include "haptics/contact/mesh_lod/surface_contact.h"

namespace typodont::haptics::mesh_lod {

/// Stiffness of every tissue, N/m: walls stand where it rises.
using Stiffness = PerTissue;

struct SurfaceOptions {
  double radius = 0;         // m, of the tool's end; 0: a point
  bool walls = true;         // one-sided walls at tissue borders
  double wall_limit = 0.5;   // N at which a wall gives way
  double unit_force = 1000;  // N/m, a material's stiffness of 1 N/mm gives so much
};

/// Wang et al. 2009, section 3.2. The paper walks from the active primitive to its neighbours while the distance to the
/// HIP falls. Here every face near the point bounds it by a plane through its nearest primitive (vertex, edge or face);
/// the point goes to where these planes come nearest to the HIP, and looks again from there until it stays. That is the
/// same walk, but it needs no neighbours, which cracks, copies and slivers do not have: the planes are those of convex
/// obstacles, so no step can pass through a face, whatever the mesh is like.
///
/// The point is the centre of a ball of the tool's radius; a point tool is a ball of `kSkin`. Servo thread; never
/// allocates.
class SurfacePoint final : public SurfaceContact {
 public:
  static constexpr double kSkin = 1e-8;        // m, the least distance that the point keeps from a face
  static constexpr double kFarthest = 1.5e-3;  // m, the largest `most` of clearance()

  SurfacePoint(const SurfaceOptions& options, const Stiffness& stiffness) : options_(options), stiffness_(stiffness) {}

  double radius() const noexcept override { return options_.radius > kSkin ? options_.radius : kSkin; }
  double reach() const noexcept override { return radius(); }
  double outlook() const noexcept override { return radius() + kFarthest; }

  /// False where p was inside the tissue or nearer to it than the radius: then the point was led out.
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
  Tissue ground_ = Tissue::kAir;  // under the point; air: it touches nothing
  bool behind_ = false;           // a wall gave way: walls are left out until the ground is the harder tissue
  Tissue beyond_ = Tissue::kAir;  // … which is this one
  // Faces near the place where they were collected, with their boxes side by side.
  static constexpr int kMostNear = 2048, kBatch = 8;
  struct Boxes {
    alignas(32) float lo_x[kMostNear + kBatch], lo_y[kMostNear + kBatch], lo_z[kMostNear + kBatch];
    alignas(32) float hi_x[kMostNear + kBatch], hi_y[kMostNear + kBatch], hi_z[kMostNear + kBatch];
  };
  std::array<std::uint32_t, kMostNear> near_{};
  int near_count_ = 0;
  Boxes boxes_{};
  const TriangleGrid* collected_ = nullptr;  // the grid that they belong to; null: they must be collected anew
  // Those of them that one look is about, as places in near_.
  std::array<std::uint32_t, kMostNear + kBatch> close_{};
  dvec3 near_from_{0};
  double near_reach_ = 0;
  // Faces of which an edge or a corner is nearest, in one look.
  struct Edge {
    std::uint32_t face = 0;
    OnFace at;
  };
  std::array<Edge, kMostNear> edges_;
  PlaneSet planes_;
  // Of the first planes, those of faces of which the inside is nearest: normals, and distances from the centre.
  struct Inner {
    alignas(32) float x[PlaneSet::kMost], y[PlaneSet::kMost], z[PlaneSet::kMost], distance[PlaneSet::kMost];
  };
  Inner inner_{};
  std::array<std::uint32_t, PlaneSet::kMost> above_{};
};

}  // namespace typodont::haptics::mesh_lod

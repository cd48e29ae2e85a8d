// The surface contact point (SCP): where the hand's point (HIP) is held outside the mesh.
#pragma once

#include <array>

#include "haptics/contact/mesh_lod/plane_set.h"
#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::mesh_lod {

/// Stiffness of every tissue, N/m: walls stand where it rises.
using Stiffness = PerTissue;

struct SurfaceOptions {
  double radius = 0;         // m, of the tool's end; 0: a point
  bool walls = true;         // one-sided walls at tissue borders
  double wall_limit = 0.5;   // N at which a wall gives way
  double unit_force = 1000;  // N/m, a material's stiffness of 1 N/mm gives so much
};

/// One place at which the surface holds the point.
struct Hold {
  dvec3 p{0};                    // m, on the surface
  dvec3 n{0};                    // unit, out of the tissue; of a wall toward the softer tissue
  double push = 0;               // m
  Tissue tissue = Tissue::kAir;  // of the face; of a wall the harder tissue
  bool wall = false;
};

/// Wang et al. 2009, section 3.2. The paper walks from the active primitive to its neighbours while the distance to the
/// HIP falls. Here every face near the point bounds it by a plane through its nearest primitive (vertex, edge or face);
/// the point goes to where these planes come nearest to the HIP, and looks again from there until it stays. That is the
/// same walk, but it needs no neighbours, which cracks, copies and slivers do not have: the planes are those of convex
/// obstacles, so no step can pass through a face, whatever the mesh is like.
///
/// The point is the centre of a ball of the tool's radius; a point tool is a ball of `kSkin`. Servo thread; never
/// allocates.
class SurfacePoint {
 public:
  static constexpr double kSkin = 1e-8;  // m, the least distance that the point keeps from a face

  SurfacePoint(const SurfaceOptions& options, const Stiffness& stiffness) : options_(options), stiffness_(stiffness) {}

  double radius() const noexcept { return options_.radius > kSkin ? options_.radius : kSkin; }
  const dvec3& place() const noexcept { return c_; }
  bool touching() const noexcept { return count_ > 0; }
  int count() const noexcept { return count_; }
  const Hold& hold(int i) const noexcept { return holds_[static_cast<std::size_t>(i)]; }
  /// A wall gave way in the last follow(), and the point went on behind it.
  bool gave_way() const noexcept { return gave_way_; }

  /// Begins at p. False where p was inside the tissue or nearer to it than the radius: then the point was led out.
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept;
  /// Goes on at p, which is known to be free.
  void put_free(const dvec3& p) noexcept;
  /// The point on another mesh: the place nearest to the old one that is outside it (SCP mapping, section 3.2).
  void map_to(const TriangleGrid& grid) noexcept;
  /// Follows the HIP. `give`: the faces that the ball overlaps are cut away as deep as it does.
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give = false) noexcept;
  /// Moves into the tissue: what follow() with `give` takes for cut away.
  void sink_to(const dvec3& c) noexcept { c_ = c; }

  /// Distance from p to the surface less the radius, at most `most`.
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) const noexcept;

 private:
  bool lift(const TriangleGrid& grid, dvec3 n) noexcept;
  void collect(const TriangleGrid& grid, double reach) noexcept;
  void round_edge(const TriangleGrid& grid, const dvec3& hip, const Plane& plane, dvec3& step) const noexcept;
  bool look(const TriangleGrid& grid, double reach, bool give) noexcept;
  void add_walls(const Face& face, std::uint32_t index, double reach, bool& room) noexcept;
  double stiffness_of(Tissue tissue) const noexcept { return stiffness_[static_cast<std::size_t>(tissue)]; }

  SurfaceOptions options_;
  Stiffness stiffness_;
  dvec3 c_{0};
  Tissue ground_ = Tissue::kAir;  // under the point; air: it touches nothing
  bool behind_ = false;           // a wall gave way: walls are left out until the ground is the harder tissue
  Tissue beyond_ = Tissue::kAir;  // … which is this one
  bool gave_way_ = false;
  int count_ = 0;
  std::array<Hold, 3> holds_;
  // Faces near the place where they were collected.
  static constexpr int kMostNear = 1024;
  std::array<std::uint32_t, kMostNear> near_{};
  int near_count_ = 0;
  dvec3 near_from_{0};
  double near_reach_ = 0;
  // Faces of which an edge or a corner is nearest, in one look.
  struct Edge {
    std::uint32_t face = 0;
    OnFace at;
  };
  std::array<Edge, kMostNear> edges_;
  PlaneSet planes_;
};

}  // namespace typodont::haptics::mesh_lod

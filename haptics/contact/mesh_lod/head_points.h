// The contact points around a head that is not a ball, and the search that lists them.
#pragma once

#include <limits>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/mesh_cutter.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::mesh_lod {

/// Returns true for a bur that is not a ball: contact is then computed for its whole head.
inline bool whole_head(const Tool& tool) noexcept {
  return tool.cuts && tool.shape != HeadShape::kSphere;
}

/// A list of the contact points around a head. Memory is allocated only in the constructor.
struct HeadPoints {
  static constexpr std::size_t kMost = 1 << 14;

  /// The part of the surface that a contact point represents.
  struct PointArea {
    dvec3 area{0};  // m², area vector; its direction is the outward normal
    Tissue tissue = Tissue::kAir;
  };

  mesh::NearPoints points{kMost};
  std::vector<PointArea> areas;  // one for each point
  // m. margin: the list contains all points within this distance of the head at the pose for which it was made
  // (points.listed_at()). kept: the list is used until the head has moved by more than this.
  double margin = 0, kept = 0;

  HeadPoints() { areas.reserve(kMost); }
};

/// Lists contact points: the corners of the faces near a head, and additional points on large faces, so that a coarse
/// mesh has enough points. A face is large if an edge is longer than the spacing of contact points for this head
/// (kSpacing). The contact model "vertex" uses the same points (contact/vertex/README.md). Cut surfaces need no
/// additional points, because their vertices are dense. Any thread; allocates only in the constructor.
class HeadLister {
 public:
  static constexpr int kNoLimit = std::numeric_limits<int>::max();

  HeadLister();

  /// Begins the list of all points within `margin` (m) of a head at X_W, to be used until the head has moved by `kept`
  /// (m). Finds the faces near the head.
  void begin(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X_W, double margin, double kept,
             HeadPoints& list) noexcept;
  /// Continues the list that begin() has begun, with the same grid, head and list. Stops when the effort reaches about
  /// `most`; a face and a contact point count 1 each. Returns true if the list is complete. The list does not depend on
  /// the number of calls.
  bool work(const TriangleGrid& grid, const vertex::VertexHead& head, HeadPoints& list, int most = kNoLimit) noexcept;
  /// Returns true while a list is being made: after begin(), until work() has returned true.
  bool open() const noexcept { return open_; }
  /// Returns true if none of these contact points is inside a head at X_W.
  static bool is_free(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X_W) noexcept;
  void cancel() noexcept { open_ = false; }

 private:
  static constexpr int kSlotBits = 15;
  // Spacing of contact points as a ratio to the head's radius. It equals the edge length of a surface that a cut
  // produces (VertexMethod::edge_for).
  static constexpr double kSpacing = 1.0 / 6;
  static double spacing(const vertex::VertexHead& head) noexcept {
    return vertex::CutParameters::longest * kSpacing * head.radius();
  }
  static constexpr std::uint32_t kFree = ~0U;

  /// A face near the head.
  struct NearFace {
    std::uint32_t face = 0;
    double longest = 0;  // m, length of the longest edge of the face
  };

  void list_points(const TriangleGrid& grid, const vertex::VertexHead& head, HeadPoints& list) noexcept;
  void add_corner(const dvec3& p, const HeadPoints::PointArea& point_area, HeadPoints& list) noexcept;

  bool open_ = false;
  glm::dmat3 R_WT_{1};
  std::vector<std::uint32_t> found_;  // faces near the head
  std::size_t at_ = 0;                // index in found_ at which work() continues
  std::vector<NearFace> near_;        // faces near the head, from the part of found_ that work() examines now
  vertex::HeadDistances distances_{HeadPoints::kMost};
  // hash table that maps the position of a corner to the index of the contact point at this position
  std::vector<std::uint32_t> slots_;
};

}  // namespace typodont::haptics::mesh_lod

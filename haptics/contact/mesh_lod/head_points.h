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

/// Returns true for a bur that is not a ball: contact is computed for its whole head, not for its end.
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
  std::vector<PointArea> areas;  // one for each contact point
  // m. margin: the list contains all contact points up to this distance from the head at the pose points.listed_at().
  // kept: displacement of the head from this pose up to which the list is used.
  double margin = 0, kept = 0;

  HeadPoints() { areas.reserve(kMost); }
};

/// Lists contact points near a head: corners of faces, and additional points on faces with an edge longer than
/// kSpacing, as in the model "vertex" (contact/vertex/README.md). Any thread; allocates only in the constructor.
class HeadLister {
 public:
  static constexpr int kNoLimit = std::numeric_limits<int>::max();

  HeadLister();

  /// Begins the list of all points within `margin` (m) of a head at X_W. The list is used until the head has moved by
  /// `kept` (m). Finds the faces near the head.
  void begin(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X_W, double margin, double kept,
             HeadPoints& list) noexcept;
  /// Continues the list with the arguments of begin(), until the effort (faces + contact points) reaches about `most`.
  /// Returns true if the list is complete. The result does not depend on the number of calls.
  bool work(const TriangleGrid& grid, const vertex::VertexHead& head, HeadPoints& list, int most = kNoLimit) noexcept;
  /// Returns true while the list of contact points is incomplete: after begin(), until work() has returned true.
  bool open() const noexcept { return open_; }
  /// Returns true if no contact point is inside the head.
  static bool is_free(const TriangleGrid& grid, const vertex::VertexHead& head, const Pose& X_W) noexcept;
  void cancel() noexcept { open_ = false; }

 private:
  static constexpr int kSlotBits = 15;
  // Spacing of contact points on a large face, in head radii; equal to VertexMethod::edge_for, the edge of cut faces.
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
  std::vector<std::uint32_t> found_;  // faces near the head's bounding box
  std::size_t at_ = 0;                // index in found_ of the next face to examine
  // faces that the current call of work() has found near the head
  std::vector<NearFace> near_;
  vertex::HeadDistances distances_{HeadPoints::kMost};
  // hash table: corner position → index of its contact point
  std::vector<std::uint32_t> slots_;
};

}  // namespace typodont::haptics::mesh_lod

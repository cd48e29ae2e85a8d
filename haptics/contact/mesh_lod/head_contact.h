// Computes the contact between a mesh and a head that is not a ball. Contact points on the faces near the head keep it
// outside the tissue.
#pragma once

#include <vector>

#include "haptics/contact/mesh_lod/surface_contact.h"
#include "haptics/contact/vertex/head_follow.h"

namespace typodont::haptics::mesh_lod {

/// Contact of a head that is not a ball. The contact points are the corners of the faces near the head. A face that is
/// larger than the spacing of contact points for this head (kSpacing) gets additional points, as in the contact model
/// "vertex" (contact/vertex/README.md); so a coarse mesh has enough points. Cut surfaces need no additional points,
/// because their vertices are dense.
class HeadContact final : public SurfaceContact {
 public:
  explicit HeadContact(const Tool& tool);

  double radius() const noexcept override { return head_.radius(); }
  double reach() const noexcept override { return head_.reach(); }
  double outlook() const noexcept override { return head_.reach() + vertex::FollowParameters::margin * head_.radius(); }
  void turn_to(const dquat& R_WT) noexcept override { R_WT_ = R_WT; }
  void mesh_changed() noexcept override { listed_ = false; }
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept override;
  void put_free(const dvec3& p) noexcept override;
  void map_to(const TriangleGrid& grid) noexcept override;
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept override;
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept override;
  PerTissue engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept override;

 private:
  static constexpr std::size_t kMostPoints = 1 << 14;
  static constexpr int kSlotBits = 15;
  // Distance between contact points, as a ratio to the head's radius. It equals the edge length of a surface that a cut
  // produces (VertexMethod::edge_for).
  static constexpr double kSpacing = 1.0 / 6;
  static constexpr int kMostParts = 64;  // largest number of parts into which an edge of a face is divided
  static constexpr std::uint32_t kFree = ~0U;

  /// The surface area that one contact point represents.
  struct Share {
    dvec3 area{0};  // m², area vector; its direction is the outward normal
    std::uint32_t face = 0;
  };

  /// A face near the head.
  struct NearFace {
    std::uint32_t face = 0;
    double longest = 0;  // m, length of the face's longest edge
  };

  /// Returns how far any point of the head has moved at most since the contact points were listed, m.
  double moved_since_listing(const dvec3& c) const noexcept;
  void list_around(const TriangleGrid& grid, const dvec3& c) noexcept;
  void list_points(const TriangleGrid& grid, const dvec3& c, const glm::dmat3& R_WT) noexcept;
  void list_where_needed(const TriangleGrid& grid, const dvec3& c) noexcept;
  void add_corner(const dvec3& p, const dvec3& area, std::uint32_t face) noexcept;
  void add(const dvec3& p, const dvec3& area, std::uint32_t face) noexcept;
  double least_distance(const dvec3& c) noexcept;

  vertex::VertexHead head_;
  dquat R_WT_{1, 0, 0, 0};
  vertex::HeadDistances distances_{kMostPoints};
  vertex::HeadFollower follower_{distances_};
  mesh::NearPoints points_{kMostPoints};
  std::vector<NearFace> near_;
  std::vector<Share> shares_;  // for each contact point: the area that it represents
  // hash table that maps the position of a corner to the index of the contact point at this position
  std::vector<std::uint32_t> slots_;
  bool listed_ = false;
};

}  // namespace typodont::haptics::mesh_lod

// Computes the contact between a mesh and a head that is not a ball. Contact points on the faces near the head keep it
// outside the tissue.
#pragma once

#include "haptics/contact/mesh_lod/head_points.h"
#include "haptics/contact/mesh_lod/mesh_lod_parts.h"
#include "haptics/contact/mesh_lod/surface_contact.h"
#include "haptics/contact/vertex/head_follow.h"

namespace typodont::haptics::mesh_lod {

/// Contact of a head that is not a ball, from the contact points around it. While one list of points is valid, the next
/// list is made in parts, one part per tick.
class HeadContact final : public SurfaceContact {
 public:
  explicit HeadContact(const Tool& tool) : head_(tool), nearest_(HeadPoints::kMost) {}

  double radius() const noexcept override { return head_.radius(); }
  double reach() const noexcept override { return head_.reach(); }
  double outlook() const noexcept override { return head_.reach() + margin(); }
  void turn_to(const dquat& R_WT) noexcept override { R_WT_ = R_WT; }
  void mesh_changed() noexcept override {
    listed_ = false;
    lister_.cancel();
    prepared_ = nullptr;
  }
  void use_prepared(HeadPoints* points) noexcept override { prepared_ = points; }
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept override;
  void put_free(const dvec3& p) noexcept override;
  void map_to(const TriangleGrid& grid) noexcept override;
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept override;
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept override;
  bool is_free(const TriangleGrid& grid, const Pose& X_W) const noexcept override {
    return HeadLister::is_free(grid, head_, X_W);
  }
  PerTissue engaged_area(const TriangleGrid& grid, const dvec3& direction) noexcept override;
  int near_planes(std::span<NearPlane, kMaxNearPlanes> planes) noexcept override;

 private:
  double margin() const noexcept { return vertex::FollowParameters::margin * head_.radius(); }
  double kept() const noexcept { return vertex::FollowParameters::kept * head_.radius(); }
  /// Largest displacement (m) of any point of the head since the points of `list` were found. `c`: current centre of
  /// the head.
  double moved_since(const HeadPoints& list, const dvec3& c) const noexcept;
  void list_where_needed(const TriangleGrid& grid, const dvec3& c) noexcept;
  void list_ahead(const TriangleGrid& grid) noexcept;
  double min_distance(const dvec3& c) noexcept;

  vertex::VertexHead head_;
  dquat R_WT_{1, 0, 0, 0};
  vertex::HeadDistances distances_{HeadPoints::kMost};
  vertex::HeadFollower follower_{distances_};
  std::vector<std::uint32_t> nearest_;  // buffer of near_planes(): indices into distances_, the nearest in front
  HeadLister lister_;
  HeadPoints list_;  // list of contact points that is in use
  HeadPoints next_;  // the next list, which lister_ makes while list_ is valid
  bool listed_ = false;
  bool gives_ = false;  // argument `give` of the last follow()
  // contact points in the current mesh that the carver thread has listed; null: none
  HeadPoints* prepared_ = nullptr;
};

}  // namespace typodont::haptics::mesh_lod

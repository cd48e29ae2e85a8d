// Contact between a tool and a mesh: the common interface of a ball (SurfacePoint) and of any other head (HeadContact).
#pragma once

#include <array>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::mesh_lod {

/// One point at which the surface holds the tool.
struct Hold {
  dvec3 p{0};                    // m, on the surface
  dvec3 n{0};                    // unit normal, pointing out of the tissue, or for a wall towards the softer tissue
  double push = 0;               // m, distance by which the surface holds the tool back
  Tissue tissue = Tissue::kAir;  // tissue of the face; for a wall the harder tissue
  bool wall = false;
};

/// Servo thread; allocates only in the constructor. Metres, frame W. place() returns the centre of the contact shape.
class SurfaceContact {
 public:
  virtual ~SurfaceContact() = default;

  const dvec3& place() const noexcept { return c_; }
  bool touching() const noexcept { return count_ > 0; }
  int count() const noexcept { return count_; }
  const Hold& hold(int i) const noexcept { return holds_[static_cast<std::size_t>(i)]; }
  /// True if a wall yielded in the last follow() and the centre moved behind it.
  bool gave_way() const noexcept { return gave_way_; }
  /// True if the last follow() moved the tool out of tissue that the tool overlapped.
  bool leading_out() const noexcept { return leading_out_; }

  /// The radius of a ball, otherwise the largest radius of the head.
  virtual double radius() const noexcept = 0;
  /// Distance from the centre to the farthest point of the contact shape.
  virtual double reach() const noexcept = 0;
  /// Distance from the centre up to which faces are examined.
  virtual double outlook() const noexcept = 0;

  /// Sets the tool's orientation for all following calls.
  virtual void turn_to(const dquat& /*R_WT*/) noexcept {}
  /// Must be called before a grid other than the last one is passed, or the last grid with changed faces.
  virtual void mesh_changed() noexcept {}

  /// Begins a contact at p. Returns false if the tool overlapped tissue there.
  virtual bool put(const TriangleGrid& grid, const dvec3& p) noexcept = 0;
  /// Continues at p, where the tool is known to be free.
  virtual void put_free(const dvec3& p) noexcept = 0;
  /// Transfers the contact to another mesh: the new position is the point outside the mesh that is nearest to the old
  /// position (SCP mapping, paper S3, section 3.2).
  virtual void map_to(const TriangleGrid& grid) noexcept = 0;
  /// Follows the hand's centre (HIP). `give`: treats faces that overlap the head as removed to the depth of the
  /// overlap.
  virtual void follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept = 0;
  /// Moves the centre into the tissue; follow() with `give` then treats the overlap as removed.
  void sink_to(const dvec3& c) noexcept { c_ = c; }

  /// Distance from the tool at p to the surface, at most `most`.
  virtual double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept = 0;
  /// Area of the surface that touches or overlaps the head, m², projected along the unit vector `way`, for each
  /// tissue.
  virtual PerTissue engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept = 0;

 protected:
  // ratio to the radius: limit of the distance from the head for a surface point that counts as in contact
  static constexpr double kOnHead = 0.03;

  dvec3 c_{0};
  int count_ = 0;
  std::array<Hold, 3> holds_;
  bool gave_way_ = false, leading_out_ = false;
};

}  // namespace typodont::haptics::mesh_lod

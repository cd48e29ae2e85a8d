// Where the mesh holds a tool: what the model needs of a ball (SurfacePoint) and of any other head (HeadContact).
#pragma once

#include <array>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::mesh_lod {

/// One place at which the surface holds the tool.
struct Hold {
  dvec3 p{0};                    // m, on the surface
  dvec3 n{0};                    // unit, out of the tissue; of a wall toward the softer tissue
  double push = 0;               // m
  Tissue tissue = Tissue::kAir;  // of the face; of a wall the harder tissue
  bool wall = false;
};

/// Servo thread; never allocates after construction. Metres, frame W. The centre of what touches is at place().
class SurfaceContact {
 public:
  virtual ~SurfaceContact() = default;

  const dvec3& place() const noexcept { return c_; }
  bool touching() const noexcept { return count_ > 0; }
  int count() const noexcept { return count_; }
  const Hold& hold(int i) const noexcept { return holds_[static_cast<std::size_t>(i)]; }
  /// A wall gave way in the last follow(), and the centre went on behind it.
  bool gave_way() const noexcept { return gave_way_; }
  /// The last follow() led the tool out of tissue that it overlapped.
  bool leading_out() const noexcept { return leading_out_; }

  /// Of a ball its own, else the head's largest.
  virtual double radius() const noexcept = 0;
  /// From the centre to the farthest point of what touches.
  virtual double reach() const noexcept = 0;
  /// How far from the centre faces are looked at.
  virtual double outlook() const noexcept = 0;

  /// The tool's orientation, for all calls that follow.
  virtual void turn_to(const dquat& /*R_WT*/) noexcept {}
  /// The next calls get another grid, or the same one with other faces.
  virtual void mesh_changed() noexcept {}

  /// Begins at p. False where the tool overlapped tissue there.
  virtual bool put(const TriangleGrid& grid, const dvec3& p) noexcept = 0;
  /// Goes on at p, which is known to be free.
  virtual void put_free(const dvec3& p) noexcept = 0;
  /// The contact on another mesh: the place nearest to the old one that is outside it (SCP mapping, S3 section 3.2).
  virtual void map_to(const TriangleGrid& grid) noexcept = 0;
  /// Follows the hand's centre (HIP). `give`: the faces that the head overlaps are cut away as deep as it does.
  virtual void follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept = 0;
  /// Moves into the tissue: what follow() with `give` takes for cut away.
  void sink_to(const dvec3& c) noexcept { c_ = c; }

  /// Distance from the tool at p to the surface, at most `most`.
  virtual double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept = 0;
  /// Area of the surface that the head lies on or overlaps, seen along the unit vector `way`, m², by tissue.
  virtual PerTissue engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept = 0;

 protected:
  static constexpr double kOnHead = 0.03;  // of the radius: what is no farther from the head lies on it

  dvec3 c_{0};
  int count_ = 0;
  std::array<Hold, 3> holds_;
  bool gave_way_ = false, leading_out_ = false;
};

}  // namespace typodont::haptics::mesh_lod

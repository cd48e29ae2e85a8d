// Common interface for the contact between a tool and a mesh. SurfacePoint implements it for a ball, HeadContact for
// any other head.
#pragma once

#include <array>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::mesh_lod {

struct HeadPoints;

/// One point at which the surface stops the tool.
struct Hold {
  dvec3 p{0};  // m, point on the surface
  // unit normal, pointing out of the tissue; for a wall between tissues, towards the softer tissue
  dvec3 n{0};
  double push = 0;               // m, distance by which this contact displaces the tool
  Tissue tissue = Tissue::kAir;  // tissue of the face; for a wall between tissues, the harder one
  bool wall = false;
};

/// Contact between one tool and a mesh. Servo thread only; allocates only in the constructor. SI units; vectors in the
/// workbench frame W. The contact shape is the ball or other head with which the tool touches the mesh.
class SurfaceContact {
 public:
  virtual ~SurfaceContact() = default;

  /// Centre of the contact shape (ball or other head), m.
  const dvec3& place() const noexcept { return c_; }
  bool touching() const noexcept { return count_ > 0; }
  int count() const noexcept { return count_; }
  const Hold& hold(int i) const noexcept { return holds_[static_cast<std::size_t>(i)]; }
  /// Returns true if a wall between tissues let the contact shape (ball or other head) through in the last follow().
  bool gave_way() const noexcept { return gave_way_; }
  /// Returns true if the last follow() moved the tool out of tissue that it overlapped.
  bool leading_out() const noexcept { return leading_out_; }

  /// Radius of the contact shape, m: of a ball, or the largest radius of any other head.
  virtual double radius() const noexcept = 0;
  /// Distance from the centre of the contact shape (ball or other head) to its farthest point, m.
  virtual double reach() const noexcept = 0;
  /// Search distance, m: faces this near to the centre of the contact shape are examined.
  virtual double outlook() const noexcept = 0;

  /// Sets the orientation of the tool for all following calls.
  virtual void turn_to(const dquat& /*R_WT*/) noexcept {}
  /// Discards data computed from the mesh. Call it after the faces have changed, and before using another grid.
  virtual void mesh_changed() noexcept {}
  /// Gives this object a list of contact points near the tool, which the carver made in the changed mesh. Call it after
  /// mesh_changed(). Until the next mesh_changed(), this object may swap `points` with its own list.
  virtual void use_prepared(HeadPoints* /*points*/) noexcept {}

  /// Starts a contact with the centre of the contact shape at p. Returns false if the tool overlaps tissue there.
  virtual bool put(const TriangleGrid& grid, const dvec3& p) noexcept = 0;
  /// Moves the centre of the contact shape (ball or other head) to p. The tool must have no contact there.
  virtual void put_free(const dvec3& p) noexcept = 0;
  /// Transfers the contact to another mesh: moves the centre of the contact shape to the point outside that mesh
  /// nearest to its old position (SCP mapping, paper S3, section 3.2).
  virtual void map_to(const TriangleGrid& grid) noexcept = 0;
  /// Follows the hand's position `hip` (haptic interface point). `give`: overlapping tissue counts as removed down to
  /// the depth of the overlap, so it does not push the head out.
  virtual void follow(const TriangleGrid& grid, const dvec3& hip, bool give) noexcept = 0;
  /// Moves the centre of the contact shape (ball or other head) to c, inside tissue. The next follow() with `give` =
  /// true treats the overlapping tissue as removed.
  void sink_to(const dvec3& c) noexcept { c_ = c; }

  /// Distance (m) from the surface to the contact shape with its centre at p, at most `most`.
  virtual double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept = 0;
  /// Returns true if the contact shape (ball or other head) at X_W overlaps no face.
  virtual bool is_free(const TriangleGrid& grid, const Pose& X_W) const noexcept = 0;
  /// Area (m²) of each tissue's surface that touches or overlaps the head, projected along the unit vector `direction`.
  virtual PerTissue engaged_area(const TriangleGrid& grid, const dvec3& direction) noexcept = 0;
  /// Writes the planes near the head after the last follow(), as ContactModel::near_planes(); x is relative to place().
  virtual int near_planes(std::span<NearPlane, kMaxNearPlanes> /*planes*/) noexcept { return 0; }

 protected:
  // A surface point is in contact if the ratio of its distance from the head to the head's radius is below this.
  static constexpr double kOnHead = 0.03;

  dvec3 c_{0};
  int count_ = 0;
  std::array<Hold, 3> holds_;
  bool gave_way_ = false, leading_out_ = false;
};

}  // namespace typodont::haptics::mesh_lod

// The exact contact for `typodont bench models`: the position of a ball that must stay outside the tissue while the
// hand pulls it. The position is computed from the exact shape (ball, torus or triangles) in double precision. This
// code is independent of the contact models, except for the grid that finds triangles near a point.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::bench {

/// The exact surface of a tissue. Metres, frame W. Only for set-up and bench time; may allocate.
class ExactShape {
 public:
  static ExactShape ball(double radius);
  /// A torus around the z axis.
  static ExactShape torus(double major, double minor);
  static ExactShape triangles(const TissueMesh& mesh);

  struct Nearest {
    dvec3 p{0};           // the nearest surface point
    double distance = 0;  // m; negative inside a closed shape
  };
  /// The surface point nearest to p. If its distance exceeds `most`, returns the distance `most` and no surface point.
  Nearest nearest(const dvec3& p, double most) const;

  /// Finds the point nearest to p of each face within `reach` of p: one point for a ball or torus, one per triangle
  /// for a mesh.
  void all_near(const dvec3& p, double reach, std::vector<dvec3>& points) const;

 private:
  enum class Kind { kBall, kTorus, kTriangles };
  Kind kind_ = Kind::kBall;
  double major_ = 0, minor_ = 0;  // m, radii of the torus; for a ball `minor_` is its radius
  std::shared_ptr<const mesh_lod::TriangleGrid> grid_;
};

/// The contact of a ball of radius `radius` with an exact shape, tick by tick.
class ReferenceContact {
 public:
  ReferenceContact(ExactShape shape, double radius) : shape_(std::move(shape)), radius_(radius) {}

  /// Places the ball at p, which must be outside the tissue.
  void place(const dvec3& p) { center_ = p; }
  /// The position nearest to the hand that the ball can have outside the tissue. The search starts at the ball's last
  /// position and finds a local minimum of the distance to the hand, so the ball never passes through a wall. The
  /// residual is below 1 nm.
  const dvec3& follow(const dvec3& hand);
  const dvec3& center() const { return center_; }
  const ExactShape& shape() const { return shape_; }
  double radius() const { return radius_; }

 private:
  bool step(const dvec3& hand);

  ExactShape shape_;
  double radius_;
  dvec3 center_{0};
  std::vector<dvec3> near_;
};

}  // namespace typodont::haptics::bench

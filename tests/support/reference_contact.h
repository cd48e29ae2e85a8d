// The exact contact: the position of a ball that must stay outside the tissue while the
// hand pulls it. It is computed from the exact shape (ball, torus or triangles) in double precision. This code shares
// nothing with the contact models, except the grid that finds the triangles near a point.
#pragma once

#include <memory>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::test {

using haptics::TissueMesh;

/// The exact surface of a tissue, in m in the workbench frame W. Used at set-up and in benchmarks; may allocate memory.
class ExactShape {
 public:
  static ExactShape ball(double radius);
  /// Returns a torus around the z axis with these radii (m).
  static ExactShape torus(double major, double minor);
  static ExactShape triangles(const TissueMesh& mesh);

  struct Nearest {
    dvec3 p{0};           // m, nearest point of the surface
    double distance = 0;  // m, distance to the surface, negative inside a closed shape
  };
  /// Returns the surface point nearest to p. If the distance is larger than `most`, the result has the distance `most`,
  /// and its point is not valid.
  Nearest nearest(const dvec3& p, double most) const;

  /// Finds the nearest point of each face within `reach` of p. A ball or a torus has one such point, and a mesh has one
  /// per triangle.
  void all_near(const dvec3& p, double reach, std::vector<dvec3>& points) const;

 private:
  enum class Kind { kBall, kTorus, kTriangles };
  Kind kind_ = Kind::kBall;
  double major_ = 0, minor_ = 0;  // m, radii of the torus; for a ball, `minor_` is the radius
  std::shared_ptr<const haptics::mesh_lod::TriangleGrid> grid_;
};

/// The contact of a ball with an exact shape, computed tick by tick.
class ReferenceContact {
 public:
  ReferenceContact(ExactShape shape, double radius) : shape_(std::move(shape)), radius_(radius) {}

  /// Sets the position of the ball, which must be outside the tissue.
  void place(const dvec3& p) { center_ = p; }
  /// Returns the position of the ball outside the tissue that is nearest to the hand. The search starts at the ball's
  /// last position and finds a local minimum of the distance to the hand, so the ball never passes through a wall. The
  /// error is below 1 nm.
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

}  // namespace typodont::test

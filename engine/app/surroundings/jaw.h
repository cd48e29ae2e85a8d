// The jaw, described in the coordinates of its arch: along the row of teeth, beside the row, and below the gum's edge.
#pragma once

#include <vector>

#include "engine/app/surroundings/plan.h"

namespace typodont {

class Jaw {
 public:
  /// A point in the coordinates of the arch, m.
  struct Place {
    /// m, position along the curve of the teeth, and distance from the curve (positive towards the cheek)
    double along, beside;
    double depth;       // m, depth below the gum's edge as it would be without papillae (the gum between teeth)
    double half_width;  // m, half the width of the row of teeth at the gum
    double x, z;        // m, coordinates in the frame of the row; x points to the front teeth, z out of the crown
  };
  /// `middle`: m, frame W, middle of the working tooth; `half_width`: m, half its width at the gum; `occlusal`: m, its
  /// highest point along the crown's axis; `roots`: m, depth of its roots below the gum's edge.
  Jaw(const SurroundingsPlan& plan, const dvec3& middle, double half_width, double occlusal, double roots);

  Place place(const dvec3& p_W) const;
  /// Returns the additional height of the gum between two teeth (the papilla), m.
  double papilla(const Place& p) const;
  /// Returns the fraction of movable mucosa in the surface of the gum, 0..1. It is 1 below the mucogingival line (lower
  /// border of the attached gum), and small at the gum's edge.
  double mucosa(const Place& p) const;

  /// Distances from a point to the bodies, m, negative inside. ridge(): the jaw without the collar of gum around the
  /// teeth.
  double ridge(const Place& p) const;
  double tongue(const Place& p) const;
  double cheek(const Place& p) const;
  double lip(const Place& p) const;
  double face(const Place& p) const;
  double rim(const Place& p) const;  // m, height of the edge of cheek and lip in the row's frame

  dvec3 to_row(const dvec3& p_W) const {
    return {glm::dot(p_W, plan_.arch), glm::dot(p_W, across_), glm::dot(p_W, plan_.crown)};
  }
  dvec3 from_row(const dvec3& p) const { return plan_.arch * p.x + across_ * p.y + plan_.crown * p.z; }
  const ArchCurve& curve() const { return curve_; }
  double occlusal() const { return occlusal_; }
  double depth() const { return depth_; }  // m, thickness of the jaw below the gum's edge

  /// m, distance from the curve of the teeth towards the cheek; behind the last tooth, distance from the end of the
  /// row.
  double from_curve(const Place& p) const;

 private:
  struct Knot {
    double along, edge, half_width;  // m; along: position along the arch; edge: height of the gum's edge
  };
  const SurroundingsPlan& plan_;
  dvec3 across_;
  ArchCurve curve_;
  std::vector<Knot> knots_;
  std::vector<double> contacts_;  // m, positions along the arch at which two teeth touch
  /// m, arch coordinates of the working tooth, and height of the gum's edge there
  double own_ = 0, beside_ = 0, own_edge_ = 0;
  double tilt_along_ = 0, tilt_beside_ = 0;
  double occlusal_ = 0, depth_ = 0, back_ = 0, own_x_ = 0;
};

}  // namespace typodont

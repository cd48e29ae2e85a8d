// The shape of the jaw in arch coordinates: along the arch, beside it, and below the gum's edge.
#pragma once

#include <vector>

#include "engine/app/surroundings/plan.h"

namespace typodont {

class Jaw {
 public:
  /// A point in the coordinates of the arch, m.
  struct Place {
    /// Positions along the arch, and beside it (positive towards the cheek), m.
    double along, beside;
    double depth;       // m, depth below the gum's edge; papillae do not count
    double half_width;  // m, half the width of the teeth at the gum
    double x, z;        // m, frame of the row of teeth: x to the front, z from root to crown
  };
  /// Lengths in m. `middle`: middle of the working tooth, frame W. `half_width`: half its width at the gum. `occlusal`:
  /// height of its highest point. `roots`: depth of its roots below the gum's edge.
  Jaw(const SurroundingsPlan& plan, const dvec3& middle, double half_width, double occlusal, double roots);

  Place place(const dvec3& p_W) const;
  /// Height of the papilla above the gum's edge, m.
  double papilla(const Place& p) const;
  /// Fraction of movable mucosa at a point of the gum, 0 to 1: 1 below the mucogingival line, small at the gum's edge.
  double mucosa(const Place& p) const;

  /// Signed distances to the bodies of the mouth, m, negative inside. ridge() does not include the gum directly around
  /// the teeth.
  double ridge(const Place& p) const;
  double tongue(const Place& p) const;
  double cheek(const Place& p) const;
  double lip(const Place& p) const;
  double face(const Place& p) const;
  double rim(const Place& p) const;  // m, height of cheek's and lip's upper edge, row's frame

  dvec3 to_row(const dvec3& p_W) const {
    return {glm::dot(p_W, plan_.arch), glm::dot(p_W, across_), glm::dot(p_W, plan_.crown)};
  }
  dvec3 from_row(const dvec3& p) const { return plan_.arch * p.x + across_ * p.y + plan_.crown * p.z; }
  const ArchCurve& curve() const { return curve_; }
  double occlusal() const { return occlusal_; }
  double depth() const { return depth_; }  // m, thickness of the jaw below the gum's edge

  /// Distance from the curve through the teeth towards the cheek, m. Behind the last tooth: from the curve's end.
  double from_curve(const Place& p) const;

 private:
  struct Knot {
    double along, edge, half_width;  // m: position along the arch; height of the gum's edge; half the tooth's width
  };
  const SurroundingsPlan& plan_;
  dvec3 across_;
  ArchCurve curve_;
  std::vector<Knot> knots_;
  std::vector<double> contacts_;  // m, positions along the arch at which two teeth touch
  /// Working tooth, m: its positions along the arch and beside the curve, and height of the gum's edge around it.
  double own_ = 0, beside_ = 0, own_edge_ = 0;
  double tilt_along_ = 0, tilt_beside_ = 0;
  double occlusal_ = 0, depth_ = 0, back_ = 0, own_x_ = 0;
};

}  // namespace typodont

// The jaw in the coordinates of its arch: along the row of teeth, beside it and below the gum's edge.
#pragma once

#include <vector>

#include "engine/app/surroundings/plan.h"

namespace typodont {

class Jaw {
 public:
  /// A point in arch coordinates, m.
  struct Place {
    double along, beside;  // position along the curve of the teeth and distance from it, see ArchCurve::Place
    double depth;          // m, depth below the gum's edge, without papillae
    double half_width;     // half the width of the row of teeth at the gum
    double x, z;           // coordinates in the row's frame; x mesial, z occlusal
  };
  /// `middle`: middle of the working tooth, m, W; `half_width`: half its width at the gum; `occlusal`: its highest
  /// point along the crown's axis; `roots`: depth of its roots below the gum's edge.
  Jaw(const SurroundingsPlan& plan, const dvec3& middle, double half_width, double occlusal, double roots);

  Place place(const dvec3& p_W) const;
  /// Additional height of the gum between two teeth.
  double papilla(const Place& p) const;
  /// Fraction of movable mucosa in the surface of the gum, 0..1: 1 below the mucogingival line, and small at the
  /// edge.
  double mucosa(const Place& p) const;

  /// Distances to the bodies, m, negative inside. ridge(): the jaw without the gum's collar.
  double ridge(const Place& p) const;
  double tongue(const Place& p) const;
  double cheek(const Place& p) const;
  double lip(const Place& p) const;
  double face(const Place& p) const;
  double rim(const Place& p) const;  // height of the cheek's and the lip's rim, in the row's frame

  dvec3 to_row(const dvec3& p_W) const {
    return {glm::dot(p_W, plan_.arch), glm::dot(p_W, across_), glm::dot(p_W, plan_.crown)};
  }
  dvec3 from_row(const dvec3& p) const { return plan_.arch * p.x + across_ * p.y + plan_.crown * p.z; }
  const ArchCurve& curve() const { return curve_; }
  double occlusal() const { return occlusal_; }
  double depth() const { return depth_; }  // thickness of the jaw below the gum's edge

  /// m, distance outwards from the curve of the teeth; also behind the last tooth.
  double from_curve(const Place& p) const;

 private:
  struct Knot {
    double along, edge, half_width;  // edge: height of the gum's edge
  };
  const SurroundingsPlan& plan_;
  dvec3 across_;
  ArchCurve curve_;
  std::vector<Knot> knots_;
  std::vector<double> contacts_;                // positions of the contact points along the arch
  double own_ = 0, beside_ = 0, own_edge_ = 0;  // position of the working tooth in arch coordinates
  double tilt_along_ = 0, tilt_beside_ = 0;
  double occlusal_ = 0, depth_ = 0, back_ = 0, own_x_ = 0;
};

}  // namespace typodont

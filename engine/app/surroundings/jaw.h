// The jaw in arch coordinates: along, beside, below the gum's edge.
#pragma once

#include <vector>

#include "engine/app/surroundings/plan.h"

namespace typodont {

class Jaw {
 public:
  /// A point in the coordinates of the arch, m.
  struct Place {
    /// m; towards the cheek positive
    double along, beside;
    double depth;       // m below the edge, without papillae
    double half_width;  // m, half the row at the gum
    double x, z;        // m, row: x to the front, z out of the crown
  };
  /// m: `middle` (W) of the working tooth, `half_width` at the gum, `occlusal` highest point, `roots` below the edge.
  Jaw(const SurroundingsPlan& plan, const dvec3& middle, double half_width, double occlusal, double roots);

  Place place(const dvec3& p_W) const;
  /// Papilla, m.
  double papilla(const Place& p) const;
  /// Movable mucosa, 0..1: 1 below the mucogingival line, little at the edge.
  double mucosa(const Place& p) const;

  /// m, negative inside. ridge(): without the collar of gum.
  double ridge(const Place& p) const;
  double tongue(const Place& p) const;
  double cheek(const Place& p) const;
  double lip(const Place& p) const;
  double face(const Place& p) const;
  double rim(const Place& p) const;  // m, edge of cheek and lip in the row

  dvec3 to_row(const dvec3& p_W) const {
    return {glm::dot(p_W, plan_.arch), glm::dot(p_W, across_), glm::dot(p_W, plan_.crown)};
  }
  dvec3 from_row(const dvec3& p) const { return plan_.arch * p.x + across_ * p.y + plan_.crown * p.z; }
  const ArchCurve& curve() const { return curve_; }
  double occlusal() const { return occlusal_; }
  double depth() const { return depth_; }  // m, thickness of the jaw below the gum's edge

  /// m towards the cheek; behind the last tooth from the row's end.
  double from_curve(const Place& p) const;

 private:
  struct Knot {
    double along, edge, half_width;  // m: along the arch; gum's edge
  };
  const SurroundingsPlan& plan_;
  dvec3 across_;
  ArchCurve curve_;
  std::vector<Knot> knots_;
  std::vector<double> contacts_;  // m, positions along the arch at which two teeth touch
  /// m, of the working tooth
  double own_ = 0, beside_ = 0, own_edge_ = 0;
  double tilt_along_ = 0, tilt_beside_ = 0;
  double occlusal_ = 0, depth_ = 0, back_ = 0, own_x_ = 0;
};

}  // namespace typodont

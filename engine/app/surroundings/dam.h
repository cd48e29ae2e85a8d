// Rubber dam: a sheet with a hole for the working tooth, and its clamp.
#pragma once

#include <vector>

#include "engine/app/surroundings/jaw.h"

namespace typodont {

/// Signed distance to the dam's rubber sheet and to all below it, m. `teeth`, `own`: distances to all teeth and to the
/// working tooth, m; `gap`: distance between the edge of the hole and the tooth, m.
double dam_sheet(const Jaw& jaw, const Jaw::Place& at, double teeth, double own, double gap);

/// The clamp: two jaws at the tooth's neck, and a bow behind it. Frame of the row of teeth, m.
class DamClamp {
 public:
  /// Middle of the tooth, height of the gum's edge, and half the tooth's width there, m.
  DamClamp(const dvec3& middle, double edge, double half_width);
  double distance(const dvec3& p_row) const;
  dvec3 low() const { return low_; }
  dvec3 high() const { return high_; }

 private:
  dvec3 middle_;  // m, middle of the tooth at the gum's edge
  double side_;   // m, distance of each of the clamp's two jaws from middle_
  std::vector<dvec3> bow_;
  dvec3 low_{0}, high_{0};
};

}  // namespace typodont

// Rubber dam: a sheet with a hole for the working tooth, and its clamp.
#pragma once

#include <vector>

#include "engine/app/surroundings/jaw.h"

namespace typodont {

/// m to the sheet and all below it. `teeth`, `own`: m; `gap`: m around the tooth.
double dam_sheet(const Jaw& jaw, const Jaw::Place& at, double teeth, double own, double gap);

/// Two jaws at the neck and a bow behind. Frame of the row, m.
class DamClamp {
 public:
  /// m: middle of the tooth, height of the gum's edge, half width there.
  DamClamp(const dvec3& middle, double edge, double half_width);
  double distance(const dvec3& p_row) const;
  dvec3 low() const { return low_; }
  dvec3 high() const { return high_; }

 private:
  dvec3 middle_;  // m, at the gum's edge
  double side_;   // m, jaws from the middle
  std::vector<dvec3> bow_;
  dvec3 low_{0}, high_{0};
};

}  // namespace typodont

// The rubber dam: a sheet that covers the row of teeth and has a hole for the working tooth, and the clamp that holds
// it.
#pragma once

#include <vector>

#include "engine/app/surroundings/jaw.h"

namespace typodont {

/// Returns the distance (m) to a solid that consists of the rubber dam's sheet and everything below it. `teeth`, `own`:
/// m, distances to the other teeth and to the working tooth; `gap`: m, distance between the hole's edge and the working
/// tooth.
double dam_sheet(const Jaw& jaw, const Jaw::Place& at, double teeth, double own, double gap);

/// The clamp of a rubber dam: two jaws at the neck of the tooth, on the sides of cheek and tongue, and a bow around its
/// rear side. Positions are in the frame of the row, m.
class DamClamp {
 public:
  /// `middle`: m, middle of the working tooth; `edge`: m, height of the gum's edge; `half_width`: m, half the width of
  /// the tooth at this height.
  DamClamp(const dvec3& middle, double edge, double half_width);
  double distance(const dvec3& p_row) const;
  dvec3 low() const { return low_; }
  dvec3 high() const { return high_; }

 private:
  dvec3 middle_;  // m, middle of the working tooth at the height of the gum's edge
  double side_;   // m, distance of the jaws of the rubber dam's clamp from the tooth's middle
  std::vector<dvec3> bow_;
  dvec3 low_{0}, high_{0};
};

}  // namespace typodont

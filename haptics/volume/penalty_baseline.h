// A penalty force, as a program computes it with OpenVDB alone: from the depth and the gradient of the level set at the
// head's centre. Only a reference for bench rows.
#pragma once

#include <memory>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

class PenaltyBaseline {
 public:
  /// Makes the level set; set-up time.
  explicit PenaltyBaseline(const DenseTissue& tissue);
  ~PenaltyBaseline();

  /// Returns the position, m, to which the surface pushes a ball's centre: from `center_W` along the field's gradient
  /// until the ball of `radius` (m) touches the surface. There is no proxy, so a ball that has passed a thin wall is
  /// pushed out on the other side.
  dvec3 push(const dvec3& center_W, double radius);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics

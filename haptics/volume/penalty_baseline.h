// A penalty force as a program computes it with OpenVDB alone: depth and gradient of the level set at the head's
// centre. Only a yardstick for bench rows.
#pragma once

#include <memory>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

class PenaltyBaseline {
 public:
  /// Set-up.
  explicit PenaltyBaseline(const DenseTissue& tissue);
  ~PenaltyBaseline();

  /// Where the surface pushes a ball's centre: from `center_W` along the field's gradient until the ball of `radius`
  /// touches the surface, m. There is no proxy: a ball that has passed a thin wall is pushed on.
  dvec3 push(const dvec3& center_W, double radius);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics

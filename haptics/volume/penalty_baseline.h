// Computes a penalty force, as a program does with OpenVDB alone: from the depth and the gradient of the level set at
// the head's centre. Only a reference for benchmarks.
#pragma once

#include <memory>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

class PenaltyBaseline {
 public:
  /// Makes the level set from the tissue. Called at set-up, because it is slow.
  explicit PenaltyBaseline(const DenseTissue& tissue);
  ~PenaltyBaseline();

  /// Returns the position (m) to which the surface pushes the centre of a ball: from `center_W` along the field's
  /// gradient, until the ball of `radius` (m) only touches the surface. There is no proxy. So if the ball has passed
  /// through a thin wall, it is pushed out on the other side.
  dvec3 push(const dvec3& center_W, double radius);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics

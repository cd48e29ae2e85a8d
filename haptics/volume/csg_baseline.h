// Removes tissue with OpenVDB's own function, the difference of two whole level sets. Used only as a reference in
// benchmarks.
#pragma once

#include <memory>

#include "engine/base/pose.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

class CsgBaseline {
 public:
  explicit CsgBaseline(const DenseTissue& tissue);
  ~CsgBaseline();

  /// Removes a ball; `radius`: m.
  void cut_ball(const dvec3& center_W, double radius);
  /// Returns the volume of the tissue, m³, computed as in TissueVolume::volumes().
  double volume() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics

// Removal as OpenVDB offers it: a constructive difference of whole level sets. Only a yardstick for bench rows.
#pragma once

#include <memory>

#include "engine/base/pose.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

class CsgBaseline {
 public:
  explicit CsgBaseline(const DenseTissue& tissue);
  ~CsgBaseline();

  /// Takes a ball away; radius in m.
  void cut_ball(const dvec3& center_W, double radius);
  /// m³, counted as TissueVolume::volumes() counts.
  double volume() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::haptics

// A scanned tooth in place of a parametric one: its measures, read from labelled tissue.
#pragma once

#include <filesystem>
#include <string>

#include "engine/app/cases/tooth.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/session/dense_field.h"

namespace typodont {

/// The tissue of a scan, in the frame of CaseTooth. For any thread.
class ScannedTooth {
 public:
  /// `copy`: dense_copy(volume). `R_WT`, `p_WT`: pose of the tooth's frame T in the frame of the volume.
  ScannedTooth(const haptics::TissueVolume& volume, const DenseCopy& copy, const glm::dmat3& R_WT, const dvec3& p_WT);
  double distance(const dvec3& p) const { return field_.distance(to_W(p)); }
  double pulp_distance(const dvec3& p) const;
  Tissue tissue(const dvec3& p) const;

 private:
  dvec3 to_W(const dvec3& p) const { return R_WT_ * p + p_WT_; }
  ToothField field_;
  VoxelFrame frame_;
  session::DenseField pulp_;  // distance to the pulp's surface
  glm::dmat3 R_WT_;
  dvec3 p_WT_;
};

/// The tooth of a scene, whose key "tooth" states its sides. `type`: one of tooth_types(). Throws Error.
CaseTooth scanned_tooth(const std::string& type, const std::filesystem::path& scene);

}  // namespace typodont

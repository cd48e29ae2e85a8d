// What all contact models share that work in a SurfacePatch: how a fresh patch learns of the cuts that it lacks.
#pragma once

#include <cstdint>

#include "haptics/contact/cut_log.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics {

/// Servo thread. The derived model makes the cuts, in patch_, and logs each of them.
class PatchModel : public ContactModel {
 public:
  void adopt(Snapshot& fresh, PerTissue& removed) noexcept final;
  const Snapshot& snapshot() const noexcept final { return patch_; }
  double travel() const noexcept final { return travel_; }
  Tissue tissue_at(const dvec3& p_W) const noexcept final;

 protected:
  explicit PatchModel(const ServoSettings& settings);
  double voxel() const noexcept { return settings_.frame.voxel; }
  /// J/m³ of the tissue at a place in the patch, voxels.
  double specific_energy_at(const dvec3& p_V) const noexcept {
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    return settings_.materials[tissue].specific_energy * hardness_at(patch_, p_V);
  }

  /// Makes a logged cut once more, in tissue that undo, redo or a loose piece has changed. The removed volume, voxels³;
  /// less than nothing by a filling.
  virtual PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept = 0;
  /// The coarse patch of `fresh` lacks the same cuts. `edited`: the old one knows nothing of an edit.
  virtual void update_coarse(SurfacePatch& /*fresh*/, bool /*edited*/) noexcept {}
  /// patch_ is a fresh one. `strokes_edited`: by undo or redo. `known`: the old one told all that has changed.
  virtual void adopted(bool strokes_edited, bool known) noexcept = 0;

  const ServoSettings& settings_;
  double travel_;  // m
  SurfacePatch patch_;
  CutLog log_;
  std::uint64_t cut_count_ = 0;

 private:
  void repeat_cuts(SurfacePatch& fresh, PerTissue& removed) noexcept;
};

}  // namespace typodont::haptics

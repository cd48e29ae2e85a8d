// Base of all contact models that work in a SurfacePatch: brings a fresh patch up to date with the cuts that it lacks.
#pragma once

#include <cstdint>

#include "haptics/contact/cut_log.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics {

/// A contact model that computes in a dense patch of the tissue. The derived model cuts in patch_ and logs each cut.
/// Servo thread.
class PatchModel : public ContactModel {
 public:
  void adopt(Snapshot& fresh, PerTissue& removed) noexcept final;
  const Snapshot& snapshot() const noexcept final { return patch_; }
  double travel() const noexcept final { return travel_; }
  Tissue tissue_at(const dvec3& p_W) const noexcept final;

 protected:
  explicit PatchModel(const ServoSettings& settings);
  double voxel() const noexcept { return settings_.frame.voxel; }
  /// Specific energy in J/m³ at a point of the patch, in voxels.
  double specific_energy_at(const dvec3& p_V) const noexcept {
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    return settings_.materials[tissue].specific_energy * hardness_at(patch_, p_V);
  }

  /// Repeats a logged cut in tissue that undo, redo or the removal of a loose piece has changed. Returns the removed
  /// volume in voxels³, negative for a filling.
  virtual PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept = 0;
  /// Applies the missing cuts to the coarse patch of `fresh`. `edited`: the old patch lacks an edit.
  virtual void update_coarse(SurfacePatch& /*fresh*/, bool /*edited*/) noexcept {}
  /// Called after patch_ was replaced. `strokes_edited`: by undo or redo. `known`: the old patch contained all changes.
  virtual void adopted(bool strokes_edited, bool known) noexcept = 0;

  const ServoSettings& settings_;
  double travel_;  // m, distance that a tool may travel inside one patch
  SurfacePatch patch_;
  CutLog log_;
  std::uint64_t cut_count_ = 0;

 private:
  void repeat_cuts(SurfacePatch& fresh, PerTissue& removed) noexcept;
};

}  // namespace typodont::haptics

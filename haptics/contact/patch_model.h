// Base class of contact models that work in a TissuePatch. It repeats the cuts that a new tissue patch lacks.
#pragma once

#include <cstdint>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// The derived class cuts in patch_ and adds each cut to log_. Servo thread only.
class PatchModel : public ContactModel {
 public:
  void adopt(Snapshot& fresh, PerTissue& removed) noexcept final;
  const Snapshot& snapshot() const noexcept final { return patch_; }
  double travel() const noexcept final { return travel_; }
  Tissue tissue_at(const dvec3& p_W) const noexcept final;

 protected:
  explicit PatchModel(const ServoSettings& settings);
  double voxel() const noexcept { return settings_.frame.voxel; }
  /// Specific cutting energy at p_V (voxels), J/m³.
  double specific_energy_at(const dvec3& p_V) const noexcept {
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    return settings_.materials[tissue].specific_energy * hardness_at(patch_, p_V);
  }
  /// Writes the volumes of a cut to `cut`, and adds the energy that it needed, J. `removed`: voxels³. `hardened`: for
  /// each tissue, removed volume × hardness, voxels³.
  void book(const PerTissue& removed, const PerTissue& hardened, Cut& cut, double& energy) const noexcept {
    const double h = voxel();
    for (std::size_t i = 1; i < removed.size(); ++i) {
      cut.removed[i] = removed[i] * h * h * h;
      energy += hardened[i] * h * h * h * settings_.materials[i].specific_energy;
    }
  }

  /// Repeats a cut in the new patch `fresh`, whose tissue an undo, a redo or the removal of a loose piece has changed.
  /// Returns the removed volume in voxels³; negative: filling.
  virtual PerTissue repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept = 0;
  /// Adds the cuts that are missing in the coarse tissue patch of the new patch `fresh`. `edited`: an undo, a redo or
  /// the removal of a loose piece changed the tissue.
  virtual void update_coarse(TissuePatch& /*fresh*/, bool /*edited*/) noexcept {}
  /// Called after a new patch has replaced patch_. `strokes_edited`: an undo or redo changed the tissue. `known`: the
  /// new patch contains no changes except the servo's own cuts.
  virtual void adopted(bool strokes_edited, bool known) noexcept = 0;

  const ServoSettings& settings_;
  double travel_;      // m, distance that the tool may move before the servo needs a new tissue patch
  TissuePatch patch_;  // has no memory until the first snapshot arrives
  CutLog log_;
  std::uint64_t cut_count_ = 0;

 private:
  void step_to(TissuePatch& fresh) noexcept;
  void repeat_cuts(TissuePatch& fresh, PerTissue& removed) noexcept;
};

}  // namespace typodont::haptics

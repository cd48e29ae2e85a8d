// Base class of all contact models that work in a SurfacePatch (copy of the field around the tool). If a new patch
// lacks some cuts, this class repeats them in it.
#pragma once

#include <cstdint>

#include "haptics/contact/cut_log.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics {

/// A contact model that works in a patch (dense copy of the field around the tool). The derived class cuts in patch_
/// and adds each cut to the log. Servo thread only.
class PatchModel : public ContactModel {
 public:
  void adopt(Snapshot& fresh, PerTissue& removed) noexcept final;
  const Snapshot& snapshot() const noexcept final { return patch_; }
  double travel() const noexcept final { return travel_; }
  Tissue tissue_at(const dvec3& p_W) const noexcept final;

 protected:
  explicit PatchModel(const ServoSettings& settings);
  double voxel() const noexcept { return settings_.frame.voxel; }
  /// Returns the specific energy in J/m³ at a point of the patch (copy of the field); `p_V` in voxels.
  double specific_energy_at(const dvec3& p_V) const noexcept {
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    return settings_.materials[tissue].specific_energy * hardness_at(patch_, p_V);
  }

  /// Repeats a logged cut in tissue that has changed by undo, redo or the removal of a loose piece. Returns the removed
  /// volume in voxels³; negative for a filling.
  virtual PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept = 0;
  /// The new patch `fresh` also contains a coarse field around the shank (coarse patch). This function repeats the cuts
  /// that are still missing in the coarse patch. `edited`: true if undo, redo or the removal of a loose piece has
  /// changed the tissue since the old patch was taken.
  virtual void update_coarse(SurfacePatch& /*fresh*/, bool /*edited*/) noexcept {}
  /// Called after patch_ (field around the tool) was replaced. `strokes_edited`: true if undo or redo has changed the
  /// tissue. `known`: true if the new patch has no changes of the tissue that the old patch lacked.
  virtual void adopted(bool strokes_edited, bool known) noexcept = 0;

  const ServoSettings& settings_;
  double travel_;  // m, distance that a tool may move inside one patch (field around it)
  SurfacePatch patch_;
  CutLog log_;
  std::uint64_t cut_count_ = 0;

 private:
  void step_to(SurfacePatch& fresh) noexcept;
  void repeat_cuts(SurfacePatch& fresh, PerTissue& removed) noexcept;
};

}  // namespace typodont::haptics

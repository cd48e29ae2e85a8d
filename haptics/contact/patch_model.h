// Models with a SurfacePatch; repeats missing cuts.
#pragma once

#include <cstdint>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/surface_patch.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// The derived class cuts patch_ and logs. Servo thread.
class PatchModel : public ContactModel {
 public:
  void adopt(Snapshot& fresh, PerTissue& removed) noexcept final;
  const Snapshot& snapshot() const noexcept final { return patch_; }
  double travel() const noexcept final { return travel_; }
  Tissue tissue_at(const dvec3& p_W) const noexcept final;

 protected:
  explicit PatchModel(const ServoSettings& settings);
  double voxel() const noexcept { return settings_.frame.voxel; }
  /// J/m³; `p_V`: voxels.
  double specific_energy_at(const dvec3& p_V) const noexcept {
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    return settings_.materials[tissue].specific_energy * hardness_at(patch_, p_V);
  }

  /// In tissue changed by undo, redo or a loose piece. Voxels³; negative: filling.
  virtual PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept = 0;
  /// Missing in the coarse patch of `fresh`. `edited`: undo, redo or a loose piece since.
  virtual void update_coarse(SurfacePatch& /*fresh*/, bool /*edited*/) noexcept {}
  /// patch_ was replaced. `strokes_edited`: undo or redo; `known`: nothing that the old one lacked.
  virtual void adopted(bool strokes_edited, bool known) noexcept = 0;

  const ServoSettings& settings_;
  double travel_;       // m of a tool in one patch
  SurfacePatch patch_;  // without memory until the first snapshot
  CutLog log_;
  std::uint64_t cut_count_ = 0;

 private:
  void step_to(SurfacePatch& fresh) noexcept;
  void repeat_cuts(SurfacePatch& fresh, PerTissue& removed) noexcept;
};

}  // namespace typodont::haptics

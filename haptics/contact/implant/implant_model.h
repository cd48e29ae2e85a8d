// The servo's part of the contact model "implant" (README.md).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "haptics/contact/implant/axial_motion.h"
#include "haptics/contact/implant/bed_criteria.h"
#include "haptics/contact/implant/end_voxels.h"
#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/contact/offset/offset_model.h"

namespace typodont::haptics::implant {

/// Kind of motion, reported in ServoTick::level. `kFree`: outside an implant bed (the drilled hole). `kPlaced`: the
/// implant stays in the bone, and the hand holds nothing. Others: motion in a bed, along and about the bed's axis.
enum class Motion : std::uint32_t {
  kFree = 0,
  kSliding = 1,
  kDrilling = 2,
  kPerforating = 3,
  kScrewing = 4,
  kPlaced = 5
};

/// Label of a placed implant; scenes give it titanium's properties.
inline constexpr Tissue kPlacedTissue = Tissue::kAmalgam;

/// Servo thread only. SI units unless another unit is stated. Frames: T tool, V voxels.
class ImplantModel final : public offset::OffsetModel {
 public:
  ImplantModel(const ServoSettings& settings, const Parameters& parameters);

  double clearance(const Pose& X_WG) noexcept override;
  void begin_anew() noexcept override;
  bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  /// None for an implant instrument, whose orientation the drilled hole holds.
  int near_planes(std::span<NearPlane, kMaxNearPlanes> planes) const noexcept override {
    return tool().implant ? 0 : OffsetModel::near_planes(planes);
  }
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;

  /// Implant beds (drilled holes) in the order of their creation.
  const std::vector<Bed>& beds() const noexcept { return beds_; }
  /// Tool voxels of the current tool, for benchmarks.
  const ToolVoxels& voxels() const noexcept { return voxels_[tool_]; }

 private:
  double stiffness(const ContactInput& in) const noexcept;
  bool tool_cuts(const ContactInput& in) const noexcept;
  Pose tool_in_bed(const Bed& bed, double tip) const noexcept;
  dquat turned_into(const Bed& bed, const dquat& R_WT) const noexcept;
  /// Evaluates the tool voxels at the tool's end. `widest`: m; bone farther than this from the axis is no obstacle.
  EndScan scan_ahead(const Pose& X_WT, bool cuts, double speed,
                     double widest = std::numeric_limits<double>::infinity()) const noexcept;
  double scan_wall(const Contact& contact) noexcept;
  double bed_depth(const Bed& bed) const noexcept;
  double reach_now() const noexcept { return OffsetModel::reach() + 2; }
  bool patch_holds(const dvec3& p_W) const noexcept;

  // The following functions are for a tool outside a bed (Motion::kFree).
  void constrain_free(const ContactInput& in, Contact& out) noexcept;
  bool touches_too_dense() const noexcept;
  bool enter_bed(const ContactInput& in, const Contact& out) noexcept;
  void feel_teeth_turn(const ContactInput& in, const Contact& contact) noexcept;
  // The following functions are for a tool in a bed (kSliding, kDrilling, kPerforating or kScrewing).
  void begin_bed_motion(std::size_t bed, double tip, const Pose& from, const dquat& R_hand) noexcept;
  void end_bed_motion(const ContactInput& in) noexcept;
  void constrain_in_bed(const ContactInput& in, Contact& out) noexcept;
  double advance(const ContactInput& in, const Bed& bed, double wanted, Contact& out) noexcept;
  double eased(const ContactInput& in, const Bed& bed, double wanted, double step) noexcept;
  double screw(const ContactInput& in, const Bed& bed, double wanted, Contact& out) noexcept;
  double thread_torque(const Bed& bed, double tip) const noexcept;
  double own_step(const ContactInput& in, double left, double& speed) const noexcept;
  void blend(const ContactInput& in, Contact& out, const Pose& state) noexcept;

  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept override;

  Parameters parameters_;
  std::vector<ToolVoxels> voxels_;  // one for each tool
  std::vector<EndVoxels> ends_;     // voxels at the end of each tool
  // Cutting law with the properties of the tissues; scan_ahead() adds the properties of the tool and the current speed.
  EndLaw law_;
  // For each tissue and hardness byte: torque of a thread in this bone divided by the torque in reference bone.
  std::array<std::array<double, 256>, kTissueCount> thread_resistance_{};
  // directions around the tool's axis, frame T
  std::array<dvec3, 12> around_thread_;
  std::vector<Bed> beds_;
  static constexpr std::size_t kMaxBeds = 64;

  bool in_bed_ = false;
  bool easing_ = false;  // true: the tool has entered a bed, but has not caught up with the hand yet
  std::size_t bed_ = 0;  // index of the bed that contains the tool
  double tip_ = 0;       // m, depth of the tip below the entry
  double entered_ = 0;   // m, depth of the tip when the tool entered the bed
  AxialState axial_;
  dquat last_R_hand_{1, 0, 0, 0};
  Motion motion_ = Motion::kFree;
  EndScan scan_;            // result of scan_ahead() in this tick
  double torque_ = 0;       // N·m, low-pass filtered torque about the tool's axis
  bool cuts_free_ = false;  // true: in this tick, the tool cuts bone outside the drilled holes (beds)
  bool seated_ = false;     // true: the implant is at its final position
  bool placed_ = false;     // true: an implant was placed; the hand holds nothing

  // m, jump of the position when the tool last entered or left a bed; added to the pose, and decreases to zero.
  dvec3 offset_{0};                             // m
  double offset_speed_ = 0, easing_speed_ = 0;  // m/s, speeds at which offset_ decreases and the tool catches up
  dquat turn_{1, 0, 0, 0};
  Pose last_;              // pose of the tool in the last tick
  bool blended_ = false;   // true: offset_ or turn_ was not zero in the last tick
  bool switched_ = false;  // true: the tool left a bed in the last tick
};

}  // namespace typodont::haptics::implant

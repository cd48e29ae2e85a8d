// The part of the contact model "implant" (README.md) that runs on the servo thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "haptics/contact/implant/axial_motion.h"
#include "haptics/contact/implant/bed_criteria.h"
#include "haptics/contact/implant/end_voxels.h"
#include "haptics/contact/implant/implant_method.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/contact/offset/offset_model.h"

namespace typodont::haptics::implant {

/// State of the tool, which this model records in ServoTick::level. `kFree`: the tool is outside a bed and has all
/// degrees of freedom. In the states 1 to 4 the tool is in a bed and can move only along the axis and about it.
/// `kPlaced`: the implant or screw stays in the bone, and the hand holds no tool.
enum class Motion : std::uint32_t {
  kFree = 0,
  kSliding = 1,
  kDrilling = 2,
  kPerforating = 3,
  kScrewing = 4,
  kPlaced = 5
};

/// Tissue label of a placed implant (a metal). Scenes assign the properties of titanium to it.
inline constexpr Tissue kPlacedTissue = Tissue::kAmalgam;

/// Contact model for the servo thread. SI units unless stated otherwise. T is the tool's frame, V the frame of the
/// voxel grid.
class ImplantModel final : public offset::OffsetModel {
 public:
  ImplantModel(const ServoSettings& settings, const Parameters& parameters);

  double clearance(const Pose& X_WG) noexcept override;
  void begin_anew() noexcept override;
  void release() noexcept override;
  bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;

  /// All existing beds, in the order of their creation.
  const std::vector<Bed>& beds() const noexcept { return beds_; }
  /// Voxels of the present tool, for benchmarks.
  const ToolVoxels& voxels() const noexcept { return voxels_[tool_]; }

 private:
  double stiffness(const ContactInput& in) const noexcept;
  bool tool_cuts(const ContactInput& in) const noexcept;
  Pose tool_in_bed(const Bed& bed, double tip) const noexcept;
  dquat turned_into(const Bed& bed, const dquat& R_WT) const noexcept;
  EndLook look_ahead(const Pose& X_WT, bool cuts, double speed) const noexcept;
  double look_at_wall(const Contact& contact) noexcept;
  double bed_depth(const Bed& bed) const noexcept;
  double reach_now() const noexcept { return OffsetModel::reach() + 2; }
  bool patch_holds(const dvec3& p_W) const noexcept;

  // Functions for the state kFree (enum Motion): the tool is outside a bed.
  void constrain_free(const ContactInput& in, Contact& out) noexcept;
  bool enter_bed(const ContactInput& in, const Contact& out) noexcept;
  void feel_teeth_turn(const ContactInput& in, Contact& out) noexcept;
  // Functions for the states 1 to 4 (enum Motion): the tool is in a bed.
  void begin_bed_motion(std::size_t bed, double tip, const Pose& from, const dquat& R_hand) noexcept;
  void end_bed_motion(const ContactInput& in) noexcept;
  void constrain_in_bed(const ContactInput& in, Contact& out) noexcept;
  double advance(const ContactInput& in, const Bed& bed, double wanted, Contact& out) noexcept;
  double eased(const ContactInput& in, const Bed& bed, double wanted, double step) noexcept;
  double screw(const ContactInput& in, const Bed& bed, double wanted, Contact& out) noexcept;
  double thread_torque(const Bed& bed, double tip) const noexcept;
  void blend(const ContactInput& in, Contact& out, const Pose& state) noexcept;

  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept override;

  Parameters parameters_;
  std::vector<ToolVoxels> voxels_;  // voxel models, one for each tool
  std::vector<EndVoxels> ends_;     // for each tool: the voxels in front of its end
  // parameters that depend on the tissues; look_ahead() adds the parameters of the tool and the present tick
  EndLaw law_;
  // For each tissue and each hardness byte: ratio of a thread's torque in this bone to its torque in the reference
  // bone.
  std::array<std::array<double, 256>, kTissueCount> thread_resistance_{};
  // unit vectors evenly spaced around the tool's axis and perpendicular to it, in the tool's frame T
  std::array<dvec3, 12> around_thread_;
  std::vector<Bed> beds_;
  static constexpr std::size_t kMostBeds = 64;

  bool in_bed_ = false;
  bool easing_ = false;  // true if the tool has just entered the bed and has not yet caught up with the hand
  std::size_t bed_ = 0;  // index of the bed that contains the tool
  double tip_ = 0;       // m, depth of the tool's tip below the bed's entry
  double entered_ = 0;   // m, depth of the tool's tip at the time when the tool entered the bed
  AxialState axial_;
  dquat last_R_hand_{1, 0, 0, 0};
  Motion motion_ = Motion::kFree;
  EndLook look_;         // result of look_ahead() in this tick: force and obstacles in front of the tool's end
  double torque_ = 0;    // N·m, low-pass filtered torque about the tool's axis
  bool seated_ = false;  // true if the implant has reached its final position and stays in the bone
  bool placed_ = false;  // true if the implant was placed in the bone; the hand then holds no tool

  // Jump of the tool's pose when the tool last entered or left a bed. It is added to the pose and fades to zero, so
  // that the pose changes gradually.
  dvec3 offset_{0};  // m, translation of the jump of the tool's pose
  dquat turn_{1, 0, 0, 0};
  Pose last_;              // pose of the tool in the last tick
  bool blended_ = false;   // true if the fading jump (offset_, turn_) was not yet zero in the last tick
  bool switched_ = false;  // true if the tool left a bed in the last tick
};

}  // namespace typodont::haptics::implant

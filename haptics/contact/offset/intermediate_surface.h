// The intermediate surface of Kim & Park 2006, section 4.4, for comparison with the default, which cuts the felt
// surface in every tick. With it, the hand feels a separate surface, which receives cuts and fillings only 30 times a
// second (update_rate) and moves to each new state continuously.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/contact/offset/offset_model.h"

namespace typodont::haptics::offset {

/// Speed of the felt surface: `removal` · force / (contact area · stiffness of the tissue / stiffness of enamel).
/// At most max_speed; without contact: max_speed.
struct IntermediateSurface {
  double update_rate = 30;  // Hz, rate at which the felt surface receives cuts and fillings
  double removal = 2e-9;    // m³/(N·s); in enamel, volume that the felt surface sweeps per newton and second
  double max_speed = 5e-3;  // m/s, largest speed of the felt surface
};

/// Two models: `cutter_` removes and fills tissue in every tick, as without an intermediate surface; `felt_` computes
/// the contact with the hand, in a distance field that gradually becomes equal to that of `cutter_`. Servo thread only.
class IntermediateModel final : public ContactModel {
 public:
  /// `mean_stiffness`: the head feels the mean of the tissue inside it, as in OffsetModel.
  IntermediateModel(const ServoSettings& settings, const IntermediateSurface& parameters, bool mean_stiffness = false);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return cutter_.snapshot(); }
  double travel() const noexcept override { return cutter_.travel(); }
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return cutter_.turns_matter(); }
  void begin_anew() noexcept override;
  void release() noexcept override;
  bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override { return cutter_.tissue_at(p_W); }

  /// The distance field that the hand feels, for tests.
  const TissuePatch& felt() const noexcept { return felt_.patch_; }

 private:
  class Part final : public OffsetModel {
   public:
    using OffsetModel::OffsetModel;
    void set_speed(double v) noexcept { surface_speed_ = v; }
    using PatchModel::log_;
    using PatchModel::patch_;
    bool fills() const noexcept { return tool().fill != Tissue::kAir; }
    void forget_creases() noexcept { contacts_.forget_creases(); }
  };
  /// A leaf (8³ samples) in which the felt field differs from its target.
  struct Moving {
    glm::ivec3 lo;       // voxels, position of the first sample
    float target[512];   // voxels, distances that the felt field approaches
    Tissue labels[512];  // tissue labels that belong to the distances in `target`
  };

  bool settled() const noexcept { return moving_.empty() && handed_over_ == cutter_.log_.last(); }
  double speed(const ContactInput& in) const noexcept;
  void hand_over() noexcept;
  void aim(const glm::ivec3& leaf) noexcept;
  void load_target(Moving& leaf) noexcept;
  void animate(const ContactInput& in) noexcept;
  bool advance(const Moving& leaf, float step) noexcept;
  void drop(std::size_t i) noexcept;
  void keep_leaf(const TissuePatch& old, const glm::ivec3& leaf) noexcept;
  void copy_marks() noexcept;
  template <class Call>
  auto with_shank(Call call) noexcept;
  std::uint32_t& slot_of(const glm::ivec3& leaf) noexcept;

  IntermediateSurface parameters_;
  double voxel_;  // m, voxel size
  Part cutter_, felt_;
  Pose X_WC_;              // pose of the head in the model cutter_
  bool has_pose_ = false;  // true: X_WC_ is valid
  ContactInput cutter_in_;
  Contact cutter_contact_;
  double area_ = 0;                   // m², contact area of the last tick
  double since_update_ = 0;           // s, time since the felt surface last received cuts
  std::uint64_t handed_over_ = 0;     // number of the last cut that the felt surface has received
  std::vector<Moving> moving_;        // leaves that still change; never reallocated
  std::vector<std::uint32_t> slots_;  // for each leaf of the patch: index in moving_ + 1; 0: none
};

}  // namespace typodont::haptics::offset

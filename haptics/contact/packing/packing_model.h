// The part of the contact model "packing" that runs on the servo thread. In each tick it computes the three passes of
// paper S2 (docs/papers.md): first contact, material there, removal along the motion.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "haptics/contact/cut_log.h"
#include "haptics/contact/offset/retreat_path.h"
#include "haptics/contact/packing/compute_passes.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"

namespace typodont::haptics::packing {

/// Servo thread. constrain() does passes 1 and 2: first contact, and the material there. cut() does pass 3: removal
/// along the motion. For a packing of millions of spheres, the model tries a GPU at the first snapshot; the passes
/// then run on the GPU if it is faster and gives the same bits. The cutting speed of eq. 4, v_d = v_b / ρ, follows
/// from the energy that the servo has earned: removing the volume dV of tissue with the specific energy u costs u dV;
/// a head with the contact area A moving at v_d costs A u v_d; and the motor delivers the power P at the teeth
/// (specific cutting energy: Shaw, "Metal Cutting Principles"; the servo's `earn` computes P by Preston's law). So
/// v_b = P / (A u_dentin) with ρ relative to dentin. A is not estimated: cut() finds the step whose removal costs the
/// earned energy.
class PackingModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument, because the tissue's spheres can only shrink, and for a tool with parts
  /// that never cut.
  PackingModel(const ServoSettings& settings, const Parameters& parameters);
  /// Uses the given passes on a GPU, even if the GPU is slower than the CPU. For tests.
  PackingModel(const ServoSettings& settings, const Parameters& parameters, std::unique_ptr<SpherePasses> passes);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double travel() const noexcept override;
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return proxy().tool().radius.size() > 1; }
  void begin_anew() noexcept override { forget_contact(); }
  void release() noexcept override { forget_contact(); }
  bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  SphereProxy& proxy() noexcept { return proxies_[tool_]; }
  const SphereProxy& proxy() const noexcept { return proxies_[tool_]; }
  void forget_contact() noexcept;
  void watch_retreat(const ContactInput& in) noexcept;
  bool lead_back(const ContactInput& in) noexcept;
  bool is_free(const ToolSpheres& tool, const Pose& X_W) const noexcept;
  void take_tissue_from_contacts() noexcept;
  void set_friction(const ContactInput& in) noexcept;
  void find_near(const Pose& to) noexcept;
  double cost(const Pose& from, const Pose& to, const Pose& near_to) noexcept;
  void load_gpu(bool first) noexcept;
  double affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most, double budget) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  PerTissue density_{};  // relative to dentin
  PerTissue energy_{};   // J/m³, specific cutting energy of each tissue, from density_
  PackingSnapshot snapshot_;
  std::vector<SphereProxy> proxies_;    // proxies, one per tool
  std::unique_ptr<ComputePasses> gpu_;  // null: CPU only
  bool gpu_must_win_ = false;           // use the GPU only if it is faster
  std::uint32_t tool_ = 0;
  bool placed_ = false;
  dvec3 held_{0};  // m, position of the proxy that was last returned to the servo
  /// State for leading a tool back along its path when contacts hold the tool far from the hand, as in the model
  /// "offset".
  struct Retreat {
    offset::RetreatPath path;  // earlier path of the tool, in units of kPathUnit
    dvec3 held_at{0};          // m, position near which the blocked proxy has stayed
    double held_for = 0;       // s, time for which the proxy has stayed near held_at with the hand far away
    bool leading = false;      // true while the proxy is led back along `path`
    std::size_t to = 0;        // index of the point of `path` to which the proxy is led
    bool wedged = false;       // the proxy is stuck: the hand is far from it, and no path back to the hand is known
  } retreat_;
  SurfaceEstimate surface_;
  CutBuffers buffers_;
  TriedCut tried_;
  std::vector<int> near_;    // result of find_near(): the lists of all spheres of the head, one after the other
  double tried_share_ = -1;  // share of the motion whose cut tried_ can make; negative: none
  std::vector<std::size_t> near_end_;  // for each list in near_: the index after its last entry
  double price_ = 0;  // J, cost of the whole motion, estimated with the last step's cost per metre; 0: unknown
  double last_path_length_ = 0;  // m, length of the whole motion in the last cut
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::packing

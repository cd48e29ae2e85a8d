// The part of the contact model "packing" that runs on the servo thread. Each tick runs the three passes of paper S2
// (docs/papers.md): first contact, material at the contact, and removal along the motion.
// README.md of this folder has an overview and defines the terms.
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

/// The contact model "packing" on the servo thread. constrain() runs passes 1 and 2 (first contact, material at the
/// contact); cut() runs pass 3 (removal along the motion). If the packing has millions of spheres, the model compares
/// CPU and GPU at the first snapshot. It uses the GPU if the GPU is faster and gives the same bits. The cutting speed
/// (paper S2, eq. 4) is v_d = v_b / ρ, with the base speed v_b and the density ρ relative to dentin. In this model, v_b
/// is computed from the energy that the motor has delivered (the servo's energy budget). To remove the volume dV of
/// tissue with the specific energy u costs the energy u dV. So a head with the contact area A that moves at v_d needs
/// the power A u v_d. The motor delivers the power P at the cutting edges (specific cutting energy: Shaw, "Metal
/// Cutting Principles"; the servo's `earn` computes P by Preston's law). So v_b = P / (A u_dentin). The area A is not
/// estimated: cut() finds the step that costs exactly the energy in the budget.
class PackingModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument, because the tissue's spheres can only shrink.
  PackingModel(const ServoSettings& settings, const Parameters& parameters);
  /// Uses the given GPU passes even if the GPU is slower than the CPU. For tests.
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
  void estimate_tissue() noexcept;
  bool postpones(double dt, double step) noexcept;
  double affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most, double budget) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  PerTissue density_{};  // density of each tissue relative to dentin
  PerTissue energy_{};   // J/m³, specific cutting energy of each tissue, from density_
  PackingSnapshot snapshot_;
  std::vector<SphereProxy> proxies_;    // proxies, one for each tool
  std::unique_ptr<ComputePasses> gpu_;  // GPU passes; null: only the CPU is used
  bool gpu_must_win_ = false;           // true: the GPU is used only if it is faster than the CPU
  std::uint32_t tool_ = 0;
  bool placed_ = false;
  dvec3 held_{0};  // m, position of the proxy that was last given to the servo
  /// Leads a tool back along its path if contacts hold it far from the hand, as in the model "offset".
  struct Retreat {
    offset::RetreatPath path;  // earlier path of the tool; its unit of length is kPathUnit
    dvec3 held_at{0};          // m, position near which the proxy has been blocked
    double held_for = 0;       // s, time that the proxy has spent near held_at while the hand was far away
    bool leading = false;      // true while the proxy is led back along `path`
    std::size_t to = 0;        // index of the path point to which the proxy is led back
    bool wedged = false;       // true if the proxy is stuck: the hand is far away, and no path back was found
  } retreat_;
  SurfaceEstimate surface_;
  Pose X_estimated_;          // pose of the proxy for which surface_ was computed
  double postponed_for_ = 0;  // s, time for which a cut has been postponed so far; 0: no cut is postponed
  CutBuffers buffers_;
  TriedCut tried_;
  // result of find_near(): for each sphere of the head, the list of tissue spheres near it, one list after the other
  std::vector<Place> near_;
  // fraction of the motion for which tried_ contains the computed cut; negative: tried_ contains no cut
  double tried_share_ = -1;
  std::vector<std::size_t> near_end_;  // for each list in near_: the index after its last entry
  // J, estimated energy for a cut along the whole motion, from the energy per metre of the last step; 0: unknown
  double price_ = 0;
  double last_path_length_ = 0;  // m, length of the whole motion for which the last cut was computed
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::packing

// "packing" on the servo thread: passes of S2 (docs/papers.md) per tick. Terms: README.md.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/offset/retreat_path.h"
#include "haptics/contact/packing/compute_passes.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/servo.h"

namespace typodont::haptics::packing {

/// constrain(): passes 1, 2; cut(): pass 3. With millions of spheres, CPU and GPU are compared at the first snapshot;
/// the GPU is used if faster with equal bits. S2, eq. 4: v_d = v_b / ρ. Here v_b comes from motor energy: a volume dV
/// costs u dV, so contact area A at v_d needs A u v_d, and with power P (Shaw, "Metal Cutting Principles"; Preston's
/// law in the servo's `earn`) v_b = P / (A u_dentin). A is not estimated: cut() finds the step that costs the budget.
class PackingModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument: spheres only shrink.
  PackingModel(const ServoSettings& settings, const Parameters& parameters);
  /// Even if slower. For tests.
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
  PerTissue energy_{};   // J/m³ per tissue, from density_
  PackingSnapshot snapshot_;
  std::vector<SphereProxy> proxies_;    // proxies, one for each tool
  std::unique_ptr<ComputePasses> gpu_;  // GPU passes; null: only the CPU is used
  bool gpu_must_win_ = false;           // only if faster
  std::uint32_t tool_ = 0;
  bool placed_ = false;
  dvec3 held_{0};  // m, last given to the servo
  /// As in "offset", for a tool held far from the hand.
  struct Retreat {
    offset::RetreatPath path;  // in kPathUnit
    dvec3 held_at{0};          // m, where the proxy is blocked
    double held_for = 0;       // s near held_at with the hand far away
    bool leading = false;      // on the way back along `path`
    std::size_t to = 0;        // path point of the way back
    bool wedged = false;       // hand far away and no way back
  } retreat_;
  SurfaceEstimate surface_;
  Pose X_estimated_;          // of surface_
  double postponed_for_ = 0;  // s postponed; 0: not
  CutBuffers buffers_;
  TriedCut tried_;
  // find_near(): lists per head sphere, in sequence
  std::vector<Place> near_;
  // of the motion, whose cut tried_ holds; negative: none
  double tried_share_ = -1;
  std::vector<std::size_t> near_end_;  // end of each list in near_
  // J for the whole motion, by the last step; 0: unknown
  double price_ = 0;
  double last_path_length_ = 0;  // m, of the last cut's whole motion
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::packing

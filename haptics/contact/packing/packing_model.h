// The servo's part of "packing": three passes of paper S2 (docs/papers.md) in each tick. README.md defines the terms.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact/retreat_path.h"
#include "haptics/servo.h"

namespace typodont::haptics::packing {

/// Passes 1 and 2: constrain(); pass 3: cut(). Cutting speed (paper S2, eq. 4): motor power / (contact area × dentin's
/// specific energy × relative density). Instead of estimating the area, cut() finds the step that uses up the energy.
class PackingModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument: spheres only become smaller.
  PackingModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return proxy().tool().turns_matter(); }
  void begin_anew() noexcept override { forget_contact(); }
  void release() noexcept override { forget_contact(); }
  bool is_free(std::uint32_t tool, const Pose& X_W) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  SphereProxy& proxy() noexcept { return proxies_[tool_]; }
  const SphereProxy& proxy() const noexcept { return proxies_[tool_]; }
  void forget_contact() noexcept;
  void watch_retreat(const ContactInput& in) noexcept;
  bool lead_back(const ContactInput& in) noexcept;
  void take_tissue_from_contacts() noexcept;
  void set_friction(const ContactInput& in) noexcept;
  void find_near(const Pose& to) noexcept;
  double cost(const Pose& from, const Pose& to) noexcept;
  void estimate_tissue() noexcept;
  bool postpones(double dt, double step) noexcept;
  double affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most, double budget) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  PerTissue density_{};  // density of each tissue divided by the density of dentin
  PerTissue energy_{};   // J/m³, specific cutting energy of each tissue, computed from density_
  PackingSnapshot snapshot_;
  std::vector<SphereProxy> proxies_;  // proxies, one for each tool
  std::uint32_t tool_ = 0;
  bool placed_ = false;
  dvec3 held_{0};               // m, head's centre that was last returned to the servo
  Retreat retreat_{1, 0.1e-3};  // positions in m, path in 0.1 mm
  SurfaceEstimate surface_;
  Pose X_estimated_;          // pose of the proxy for which surface_ was computed
  double postponed_for_ = 0;  // s, time since the cut was postponed; 0: not postponed
  CutBuffers buffers_;
  TriedCut tried_;
  // Result of find_near(): for all spheres of the head, the lists of tissue spheres near them, one after another.
  std::vector<Place> near_;
  // tried_ contains a trial cut along this fraction of the motion from proxy to hand; negative: no trial cut
  double tried_share_ = -1;
  std::vector<std::size_t> near_end_;  // for each list in near_: index after its last element
  // J, estimated energy of a cut along the whole motion from proxy to hand; 0: unknown
  double price_ = 0;
  double last_path_length_ = 0;  // m, length of the motion from proxy to hand at the last cut
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::packing

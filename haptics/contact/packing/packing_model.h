// The servo's half of "packing": the three passes of S2 in a tick.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/cut_log.h"
#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/sphere_proxy.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"

namespace typodont::haptics::packing {

/// Servo thread. Pass 1, first contact: constrain(). Passes 2 and 3, the material there and its removal: cut().
///
/// The cutting speed of eq. 4, v_d = v_b / ρ, follows from the energy that the servo has earned: removing the volume dV
/// of tissue with the specific energy u costs u dV, a head with the contact area A that goes on at v_d costs A u v_d,
/// and the motor gives the power P at the teeth (specific cutting energy: Shaw, "Metal Cutting Principles"; the servo's
/// `earn` has Preston's law for P). So v_b = P / (A u_dentin) with ρ over dentin's. A is not estimated: cut() finds the
/// step whose removal costs what has been earned.
class PackingModel final : public ContactModel {
 public:
  /// Throws Error for a tool that fills or has parts that never cut: spheres only shrink.
  PackingModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double travel() const noexcept override;
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return proxy().tool().radius.size() > 1; }
  void begin_anew() noexcept override { placed_ = false; }
  void release() noexcept override { placed_ = false; }
  bool may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  SphereProxy& proxy() noexcept { return proxies_[tool_]; }
  const SphereProxy& proxy() const noexcept { return proxies_[tool_]; }
  bool is_free(const ToolSpheres& tool, const Pose& X_W) const noexcept;
  void take_tissue_from_contacts() noexcept;
  void set_friction(const ContactInput& in) noexcept;
  void find_near(const Pose& from, const Pose& to) noexcept;
  double cost(const Pose& from, const Pose& to) const noexcept;
  double affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most, double budget) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  PerTissue density_{};  // over dentin's
  PerTissue energy_{};   // J/m³, specific cutting energy by these densities
  PackingSnapshot snapshot_;
  std::vector<SphereProxy> proxies_;  // one a tool
  std::uint32_t tool_ = 0;
  bool placed_ = false;
  dvec3 held_{0};  // m, where the servo was told that the tool is
  SurfaceEstimate surface_;
  CutBuffers buffers_;
  std::vector<int> near_;              // spheres near the way of a cut, for one sphere of the head after the other
  std::vector<std::size_t> near_end_;  // where those of each sphere of the head end
  double price_ = 0;                   // J that the whole way would cost by the price of the last step; 0: not known
  double last_way_ = 0;                // m, the whole way in the last cut
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::packing

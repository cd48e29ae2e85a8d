// Runs the three passes of the contact model "packing" on a GPU. All sums are computed in the same order as on the CPU,
// so the results have the same bits.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

/// The GPU is used only for at least this number of tissue spheres. With fewer spheres, the CPU finishes before the GPU
/// has started.
inline constexpr std::size_t kWorthAGpu = 1'000'000;

/// Runs the three passes on a GPU. Servo thread only. All functions are noexcept and allocate no memory, except in the
/// GPU's driver. If a pass fails, ready() returns false until the next load(), and the caller computes on the CPU.
class ComputePasses {
 public:
  /// `tools`: the sphere models of all tools that will be used.
  ComputePasses(std::unique_ptr<SpherePasses> passes, std::span<const ToolSpheres> tools);

  std::string device() const { return passes_->device(); }
  bool ready() const noexcept { return ready_; }
  void load(const SphereTissue& tissue) noexcept;

  /// Pass 1: finds the first contact between moving spheres of the tool and the tissue.
  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept;
  /// Pass 2: estimates the tissue's surface at the contact, with the same result as estimate_surface() on the CPU.
  /// `X_WP`: pose of the proxy; `p_WC`: point of contact.
  bool estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                        double epsilon, const PerTissue& density, SurfaceEstimate& estimate) noexcept;
  /// Pass 3 without a change of the tissue: computes the energy in J that a motion of the head from `from` to `to`
  /// costs. `near_to`: end of the longest motion for which the cost will be computed in this tick; the spheres near
  /// this motion are searched only once.
  bool cost(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to,
            const PerTissue& energy, double& joules) noexcept;
  /// Pass 3: removes the tissue on the tool's motion from X_WA to X_WB, with the same result as packing::carve() on the
  /// CPU.
  bool carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, Removed& removed,
             bool& changed) noexcept;

 private:
  void put_cutting(const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to) noexcept;

  std::unique_ptr<SpherePasses> passes_;
  bool ready_ = false;
  std::vector<RestingBall> resting_;
  std::vector<CuttingBall> cutting_;
  std::vector<std::uint32_t> number_;  // for each ball in resting_: index of the tool's sphere
  std::vector<SphereShare> shares_;    // overlaps, sorted into the order in which the CPU sums them
  std::vector<SphereChange> changes_;
  std::vector<CutSphere> loaded_;  // the tissue's spheres in the order of their indices; buffer for the copy to the GPU
};

/// Mean computing times of the passes on the CPU and on a GPU.
struct PassTimes {
  double processor = 0, gpu = 0;  // s, mean time per tool position on the CPU and on the GPU
  bool same = true;               // true if CPU and GPU gave the same bits in all tests
  /// Returns true if the GPU is faster and gives the same bits.
  bool gpu_is_better() const { return same && gpu < processor; }
};
/// Measures the three passes on the CPU and on the GPU. `tissue` must already be loaded on the GPU. Called only during
/// set-up, because the measurement takes several ticks.
PassTimes compare_passes(const SphereTissue& tissue, const ToolSpheres& tool, ComputePasses& passes,
                         CutBuffers& buffers, int looks);

}  // namespace typodont::haptics::packing

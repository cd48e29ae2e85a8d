// The three passes on a GPU. Sums in the CPU's order, so bits agree.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

/// Spheres; with fewer, the CPU is done before the GPU starts.
inline constexpr std::size_t kWorthAGpu = 1'000'000;

/// Servo thread; noexcept; allocates only in the GPU's driver. After a failure ready() is false until load(), and the
/// caller uses the CPU.
class ComputePasses {
 public:
  /// `tools`: all that will be used.
  ComputePasses(std::unique_ptr<SpherePasses> passes, std::span<const ToolSpheres> tools);

  std::string device() const { return passes_->device(); }
  bool ready() const noexcept { return ready_; }
  void load(const SphereTissue& tissue) noexcept;

  /// Pass 1: first contact.
  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept;
  /// Pass 2, as estimate_surface(). `X_WP`: proxy; `p_WC`: contact.
  bool estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                        double epsilon, const PerTissue& density, SurfaceEstimate& estimate) noexcept;
  /// Pass 3 without a change: J of the head's motion. `near_to`: end of the longest motion in this tick, whose spheres
  /// are searched once.
  bool cost(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to,
            const PerTissue& energy, double& joules) noexcept;
  /// Pass 3 from X_WA to X_WB, as packing::carve().
  bool carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, Removed& removed,
             bool& changed) noexcept;

 private:
  void put_cutting(const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to) noexcept;

  std::unique_ptr<SpherePasses> passes_;
  bool ready_ = false;
  std::vector<RestingBall> resting_;
  std::vector<CuttingBall> cutting_;
  std::vector<std::uint32_t> number_;  // tool sphere of each ball in resting_
  std::vector<SphereShare> shares_;    // in the order of the CPU's sums
  std::vector<SphereChange> changes_;
  std::vector<CutSphere> loaded_;  // by index, to copy to the GPU
};

/// Means, CPU and GPU.
struct PassTimes {
  double processor = 0, gpu = 0;  // s per tool position
  bool same = true;               // equal bits in all tests
  /// Faster, with equal bits.
  bool gpu_is_better() const { return same && gpu < processor; }
};
/// Takes several ticks: set-up only, with `tissue` loaded.
PassTimes compare_passes(const SphereTissue& tissue, const ToolSpheres& tool, ComputePasses& passes,
                         CutBuffers& buffers, int looks);

}  // namespace typodont::haptics::packing

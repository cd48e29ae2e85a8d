// The three passes of a tick on a GPU. Sums are added in the CPU's order, so both give bit-identical results.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

/// Smallest number of tissue spheres for a GPU; with fewer, the CPU finishes before a GPU has started.
inline constexpr std::size_t kWorthAGpu = 1'000'000;

/// Servo thread only; noexcept; allocates only in the GPU's driver. After a failure, ready() is false until load() is
/// called, and the caller uses the CPU.
class ComputePasses {
 public:
  /// `tools`: all tools that will be used, as spheres.
  ComputePasses(std::unique_ptr<SpherePasses> passes, std::span<const ToolSpheres> tools);

  std::string device() const { return passes_->device(); }
  bool ready() const noexcept { return ready_; }
  void load(const SphereTissue& tissue) noexcept;

  /// Pass 1: finds the first contact of moving balls. Returns false after a failure.
  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept;
  /// Pass 2 on the GPU, like estimate_surface(). `X_WP`: pose of the proxy; `p_WC`: contact point.
  bool estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                        double epsilon, const PerTissue& density, SurfaceEstimate& estimate) noexcept;
  /// Pass 3 without changing the tissue: returns the energy (J) to cut along the head's motion. `near_to`: end of the
  /// longest motion in this tick; tissue spheres near it are searched only once.
  bool cost(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to,
            const PerTissue& energy, double& joules) noexcept;
  /// Pass 3 on the GPU: cuts from X_WA to X_WB, like packing::carve().
  bool carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, Removed& removed,
             bool& changed) noexcept;

 private:
  void put_cutting(const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to) noexcept;

  std::unique_ptr<SpherePasses> passes_;
  bool ready_ = false;
  std::vector<RestingBall> resting_;
  std::vector<CuttingBall> cutting_;
  std::vector<std::uint32_t> number_;  // for each ball in resting_: index of its tool sphere
  std::vector<SphereShare> shares_;    // overlaps of spheres, in the order in which the CPU adds them
  std::vector<SphereChange> changes_;
  std::vector<CutSphere> loaded_;  // all spheres by index, to copy them to the GPU
};

/// Mean times of the three passes together, on CPU and on GPU.
struct PassTimes {
  double processor = 0, gpu = 0;  // s, mean time of the three passes for one position of the tool
  bool same = true;               // true: CPU and GPU gave bit-identical results in all tests
  /// Returns true if the GPU is faster and its results are bit-identical.
  bool gpu_is_better() const { return same && gpu < processor; }
};
/// Measures and compares the passes on CPU and GPU at `looks` positions of the tool. Takes as long as several ticks, so
/// at set-up only, after `tissue` was loaded.
PassTimes compare_passes(const SphereTissue& tissue, const ToolSpheres& tool, ComputePasses& passes,
                         CutBuffers& buffers, int looks);

}  // namespace typodont::haptics::packing

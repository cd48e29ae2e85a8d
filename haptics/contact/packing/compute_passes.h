// The three passes on a GPU, as the model uses them: the same sums in the same order as on the processor.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/contact/packing/packing_parts.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/sphere_passes.h"

namespace typodont::haptics::packing {

/// Packings with fewer spheres are not tried on a GPU: the tree on the processor answers before a GPU has begun.
inline constexpr std::size_t kWorthAGpu = 1'000'000;

/// Servo thread. noexcept, and does not allocate beyond what the GPU's driver does. Once a pass has failed, ready() is
/// false until the next load(), and the caller does the same on the processor.
class ComputePasses {
 public:
  /// `tools`: all that may be asked for.
  ComputePasses(std::unique_ptr<SpherePasses> passes, std::span<const ToolSpheres> tools);

  std::string device() const { return passes_->device(); }
  bool ready() const noexcept { return ready_; }
  void load(const SphereTissue& tissue) noexcept;

  /// Pass 1.
  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept;
  /// Pass 2: as the other estimate_surface().
  bool estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP, const dvec3& p_WC,
                        double epsilon, const PerTissue& density, SurfaceEstimate& estimate) noexcept;
  /// Pass 3, only measured: J that the head's way from `from` to `to` costs; `near_to`: the end of the longest way.
  bool cost(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to,
            const PerTissue& energy, double& joules) noexcept;
  /// Pass 3: as carve().
  bool carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB, Removed& removed,
             bool& changed) noexcept;

 private:
  void put_cutting(const ToolSpheres& tool, const Pose& from, const Pose& to, const Pose& near_to) noexcept;

  std::unique_ptr<SpherePasses> passes_;
  bool ready_ = false;
  std::vector<RestingBall> resting_;
  std::vector<CuttingBall> cutting_;
  std::vector<std::uint32_t> number_;  // of each resting ball in the tool
  std::vector<SphereShare> shares_;    // in the processor's order
  std::vector<SphereChange> changes_;
};

/// What one tick's passes take on the processor and on a GPU, over several places at the tissue's spheres.
struct PassTimes {
  double processor = 0, gpu = 0;  // s
  bool same = true;               // all results have the same bits
  /// A GPU is chosen where it is faster and gives the same bits.
  bool gpu_is_better() const { return same && gpu < processor; }
};
/// `tissue` must be loaded. Set-up: takes some ticks' time.
PassTimes compare_passes(const SphereTissue& tissue, const ToolSpheres& tool, ComputePasses& passes,
                         CutBuffers& buffers, int looks);

}  // namespace typodont::haptics::packing

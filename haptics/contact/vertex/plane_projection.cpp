#include "haptics/contact/vertex/plane_projection.h"

#include <algorithm>

namespace typodont::haptics::vertex {

namespace {

/// Presents the bounds on a step of the head to the active-set solver, in metres. `only_no_deeper`: true if bounds that
/// the head already violates only prevent a deeper overlap.
class StepBounds {
 public:
  using Plane = StepBound;
  // Lower limits for the linear systems of the solver; below them, a system counts as singular. The values suit
  // neighbouring vertices of a fine mesh.
  static constexpr ActiveSetLimits kLimits = {.least_pivot = 1e-9, .least_rest = 1e-8};

  StepBounds(std::span<const StepBound> bounds, bool only_no_deeper)
      : bounds_(bounds), only_no_deeper_(only_no_deeper) {}

  const StepBound& plane(int i) const noexcept { return bounds_[static_cast<std::size_t>(i)]; }
  double excess(const StepBound& bound, const dvec3& step) const noexcept {
    return glm::dot(bound.n, step) + (only_no_deeper_ ? std::max(bound.gap, 0.0) : bound.gap);
  }
  int worst(const dvec3& step, const int* active, int count) const noexcept {
    double least = -1e-12;  // m, tolerance by which a bound may be violated
    int worst = -1;
    for (int i = 0; i < static_cast<int>(bounds_.size()); ++i) {
      if (const double e = excess(plane(i), step); e < least) least = e, worst = i;
    }
    return std::find(active, active + count, worst) == active + count ? worst : -1;
  }

 private:
  std::span<const StepBound> bounds_;
  bool only_no_deeper_;
};

}  // namespace

dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted, ActivePlanes& active) noexcept {
  dvec3 step;
  for (const bool only_no_deeper : {false, true}) {
    active.count = 0;
    if (ActiveSet(StepBounds(bounds, only_no_deeper)).solve(wanted, step, active)) return step;
  }
  active.count = 0;
  return dvec3(0);
}

}  // namespace typodont::haptics::vertex

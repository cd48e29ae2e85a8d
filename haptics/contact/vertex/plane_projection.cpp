#include "haptics/contact/vertex/plane_projection.h"

#include <algorithm>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::vertex {

namespace {

/// Index of the bound of a step that is violated most, by more than `tolerance` (m); of equal ones the first; -1: none.
/// `only_no_deeper`: points inside the head only prevent a deeper overlap.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
int find_worst(const StepBounds& bounds, const double* step, bool only_no_deeper, double tolerance) {
  constexpr std::size_t kBatch = 8;
  const D8 zero = {};
  D8 least = zero - tolerance;
  L8 at = L8{} - 1, index = {0, 1, 2, 3, 4, 5, 6, 7};
  for (std::size_t k = 0; k < bounds.count; k += kBatch, index += kBatch) {
    D8 x, y, z, gap;
    read_lanes(x, bounds.n_x + k), read_lanes(y, bounds.n_y + k), read_lanes(z, bounds.n_z + k);
    read_lanes(gap, bounds.gap + k);
    if (only_no_deeper) gap = gap < 0.0 ? zero : gap;
    const D8 excess = gap - (x * step[0] + y * step[1] + z * step[2]);
    const L8 worse = excess < least;
    least = worse ? excess : least;
    at = worse ? index : at;
  }
  int worst = -1;
  double most = -tolerance;
  for (std::size_t i = 0; i < kBatch; ++i) {
    const int here = static_cast<int>(at[i]);
    if (least[i] < most || (least[i] == most && here >= 0 && here < worst)) most = least[i], worst = here;
  }
  return worst;
}

/// Gives the active-set solver the bounds of a step of the head (StepBounds) as planes, in m.
class BoundPlanes {
 public:
  struct Plane {
    dvec3 n;  // unit vector, push on the head
    double gap;
  };
  // Very small limits for linear dependence of normals, because neighbouring points of a fine mesh have nearly equal
  // normals.
  static constexpr ActiveSetLimits kLimits = {.min_pivot = 1e-9, .min_rest = 1e-8};

  BoundPlanes(const StepBounds& bounds, bool only_no_deeper) : bounds_(bounds), only_no_deeper_(only_no_deeper) {}

  Plane plane(int i) const noexcept {
    const auto at = static_cast<std::size_t>(i);
    return {-dvec3(bounds_.n_x[at], bounds_.n_y[at], bounds_.n_z[at]), bounds_.gap[at]};
  }
  double excess(const Plane& plane, const dvec3& step) const noexcept {
    return glm::dot(plane.n, step) + (only_no_deeper_ ? std::max(plane.gap, 0.0) : plane.gap);
  }
  int worst(const dvec3& step, const int* active, int count) const noexcept {
    constexpr double kTolerance = 1e-12;  // m, violation that is ignored
    const int worst = find_worst(bounds_, &step.x, only_no_deeper_, kTolerance);
    return std::find(active, active + count, worst) == active + count ? worst : -1;
  }

 private:
  const StepBounds& bounds_;
  bool only_no_deeper_;
};

}  // namespace

dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept {
  dvec3 step;
  for (const bool only_no_deeper : {false, true}) {
    active.count = 0;
    if (ActiveSet(BoundPlanes(bounds, only_no_deeper)).solve(wanted, step, active)) return step;
  }
  active.count = 0;
  return dvec3(0);
}

}  // namespace typodont::haptics::vertex

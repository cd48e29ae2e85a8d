#include "haptics/contact/vertex/head_follow.h"

#include <algorithm>
#include <cstddef>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::vertex {

using P = FollowParameters;

namespace {

/// Bounds of a step of the head: n·step <= gap for each contact point. For SIMD, the arrays have eight more elements,
/// with huge gaps and finite normals.
struct StepBounds {
  const double *n_x, *n_y, *n_z;  // unit vector from the head to each point
  const double* gap;              // m, distance of each point from the head; negative: overlap
  std::size_t count;
};

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

/// Allowed step nearest to `wanted` (Goldfarb & Idnani 1983). If there is none, points inside the head only prevent a
/// deeper overlap; if there is still none, the step is 0. `active`: receives the bounds that limit the step.
dvec3 nearest_step(const StepBounds& bounds, const dvec3& wanted, ActivePlanes& active) noexcept {
  dvec3 step;
  for (const bool only_no_deeper : {false, true}) {
    active.count = 0;
    if (ActiveSet(BoundPlanes(bounds, only_no_deeper)).solve(wanted, step, active)) return step;
  }
  active.count = 0;
  return dvec3(0);
}

}  // namespace

bool HeadFollower::approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT,
                            double allowed_depth, bool give, double most) noexcept {
  constexpr double kUnbounded = 1e300;  // m, gap of unused elements; it never limits a step
  const double radius = head.radius();
  const dvec3 rest = X_WT.p - at;
  const double left = glm::length(rest);
  distances_.find(head, points, {at, X_WT.R}, most);
  const HeadDistances::Columns near = distances_.columns();
  double least = 0;
  for (std::size_t i = 0; i < near.count; ++i) {
    const double d = near.distance[i];
    least = std::min(least, d);
    gaps_[i] = allowed_motion(d, allowed_depth, give);
  }
  for (std::size_t i = near.count; i < near.count + HeadDistances::kBatch; ++i) gaps_[i] = kUnbounded;
  if (least < -P::led_out * radius) led_out_ = true;
  bounded_ = near.count > 0;
  dvec3 step = nearest_step({near.n_x, near.n_y, near.n_z, gaps_.data(), near.count},
                            left > most ? most / left * rest : rest, active_);
  for (int i = 0; i < active_.count; ++i) {
    const auto k = static_cast<std::size_t>(active_.index[i]);
    holds_[i] = {distances_.point(k), -distances_.normal_W(k), active_.push[i]};
  }
  const double length = glm::length(step);
  if (length > most) step *= most / length;
  at += step;
  return left > most && length >= P::settled * most;
}

}  // namespace typodont::haptics::vertex

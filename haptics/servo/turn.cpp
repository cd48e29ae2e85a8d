// The proxy's orientation: tissue also holds back the tool's rotation, if the device renders torque. Servo thread only.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = TurnParameters;

namespace {

/// Returns the next fraction 0..1 of a step to make. Planes replace curved walls, so full steps could alternate for
/// ever; a step that reverses the `last` one halves the fraction.
double next_fraction(double fraction, const dvec3& step, dvec3& last) noexcept {
  const bool reverses = glm::dot(step, last) < 0;
  last = step;
  return reverses ? std::max(P::shorter * fraction, P::shortest) : std::min(P::longer * fraction, 1.0);
}

}  // namespace

bool Servo::State::feels_turns() const noexcept {
  const Tool& held = tool();
  return settings.gives_torque && held.fill == Tissue::kAir &&
         (held.shape != HeadShape::kSphere || shank_of(held) || safe_end_of(held));
}

/// Copies the planes that hold the tool, with their pushes.
void Servo::State::keep_holds(const ActivePlanesOf<6>& active) noexcept {
  Turning& t = turning;
  dvec3 sum(0);
  double most = 0;
  for (int i = 0; i < active.count; ++i) {
    const NearPlane& plane = t.planes[static_cast<std::size_t>(active.index[i])];
    const double push = active.push[i];
    t.push += push;
    t.lever += push * plane.x;
    sum += push * plane.n;
    if (push > most) most = push, t.normal = plane.n;
    t.holds[static_cast<std::size_t>(i)] = {plane.x, plane.n, push};
  }
  t.count = active.count;
  if (t.push > 0) t.lever /= t.push;
  t.opposed = glm::length(sum) < P::opposed * t.push;
}

/// Computes the allowed motion nearest to `wanted`, and the planes that hold the tool. Planes that hold the tool are
/// computed exactly, because approximate ones would turn the tool by their errors. Returns the number of planes.
int Servo::State::nearest_step(const PoseStep& wanted, double lever, PoseStep& step,
                               ActivePlanesOf<6>& active) noexcept {
  Turning& t = turning;
  const double voxel = settings.frame.voxel;
  int count = 0;
  for (int round = 0; round < P::refining_rounds; ++round) {
    count = model->near_planes(t.planes);
    const std::span planes(t.planes.data(), static_cast<std::size_t>(count));
    t.bounds.set(planes, lever, P::overlap * voxel, P::led_out * voxel);
    bool found = t.bounds.nearest(wanted, step, active);
    if (!found) {
      t.bounds.set(planes, lever, P::overlap * voxel, 0);
      found = t.bounds.nearest(wanted, step, active);
    }
    if (!found) {
      // Rounding errors: the proxy keeps its orientation in this tick.
      step = {wanted.p, dvec3(0)};
      active.count = 0;
      break;
    }
    bool refined = false;
    for (int i = 0; i < active.count; ++i) refined |= model->refine_near_plane(active.index[i]);
    if (!refined) break;
  }
  return count;
}

/// Computes where the proxy is after it has turned by `r` (PoseStep::r). Between opposed walls, a search at a fixed
/// orientation would be inexact, so the planes determine the place; elsewhere, they only give the start of the search.
/// May reduce `r`, because the proxy must not move much faster than the hand. `wanted`: m, from the proxy to the hand.
void Servo::State::place(ContactTick& now, const dvec3& wanted, dvec3& r) noexcept {
  Turning& t = turning;
  dvec3 own, step;  // with the hand, and as near to it as allowed
  if (!(t.count > 0 && t.opposed && t.bounds.nearest_shift(r, now.moved, own) &&
        t.bounds.nearest_shift(r, wanted, step))) {
    if (t.bounds.nearest_shift(r, dvec3(0), own)) now.in.X_WG.p += own;
    return;
  }
  const dvec3 rest = step - own;
  t.follow = next_fraction(t.follow, rest, t.last_rest);
  step = own + t.follow * rest;
  const double fraction = max_fraction(
      step, -now.moved, P::slew * now.dt / (settings.stiffness * std::max(coupling.relative_stiffness, P::softest)));
  r *= fraction;
  now.in.X_WT.p = motion.X_WG.p + fraction * step;
  now.in.placed = true;
}

void Servo::State::turn(ContactTick& now) noexcept {
  Turning& t = turning;
  const bool lagged = t.lags && motion.X_WG.R != motion.last_hand.R;
  t.lags = false;
  t.count = 0;
  t.push = 0;
  t.lever = dvec3(0);
  const bool acts = !now.in.removal.cuts && coupling.tip.penetration <= 0 && !now.jumped && motion.leap <= 0;
  if (!acts && !lagged) return;
  const double lever = std::sqrt(P::stiffness / settings.stiffness);
  const PoseStep wanted{now.X_WT.p - motion.X_WG.p, lever * rotation_vector(motion.X_WG.R, now.X_WT.R)};
  ActivePlanesOf<6> active;
  PoseStep step = wanted;
  const int count = acts ? nearest_step(wanted, lever, step, active) : 0;
  const dvec3 change = step.r - wanted.r;
  const bool held = glm::dot(change, change) > P::rounding * P::rounding * lever * lever;
  if (!held && (!lagged || (acts && count == 0))) return;
  if (!lagged) t.turn = t.follow = 1, t.last_turn = t.last_rest = dvec3(0);
  t.turn = next_fraction(t.turn, step.r, t.last_turn);
  if (held) step.r *= t.turn;
  double reach = 0;
  for (int i = 0; i < count; ++i) {
    const dvec3& x = t.planes[static_cast<std::size_t>(i)].x;
    reach = std::max(reach, glm::dot(x, x));
  }
  reach = count > 0 ? std::sqrt(reach) : tool().reach();
  const double angle = glm::length(step.r) / lever, most = P::arc * settings.frame.voxel / reach;
  if (!held && angle <= most) return;  // arrives at the hand's orientation
  if (angle > most) step.r *= most / angle;
  if (held) keep_holds(active);
  if (count > 0) place(now, wanted.p, step.r);
  const double turned = glm::length(step.r) / lever;
  t.R = motion.X_WG.R;
  if (turned > 0) t.R = glm::normalize(glm::angleAxis(turned, step.r / (turned * lever)) * t.R);
  t.lags = std::abs(glm::dot(t.R, t.R) - 1) < P::rounding;  // false for NaN: no valid plane
  if (t.lags) {
    now.in.X_WT.R = t.R;
  } else {
    now.in.placed = false, now.in.X_WT = now.X_WT, now.in.X_WG = motion.X_WG, t.count = 0;
  }
}

void Servo::State::hold_turn(ContactTick& now) noexcept {
  Turning& t = turning;
  Contact& contact = now.contact;
  t.lags = t.lags && !contact.gap.lost && !contact.deep;
  if (!t.lags) return;
  contact.orientation.held = true;
  contact.orientation.R_WG = t.R;
  t.twist = rotation_vector(now.X_WT.R, t.R);
  contact.touching = true;
}

/// Tissues under the contacts that only hold the tool's orientation, for contacts whose tissue the model has not read.
void Servo::State::feel_held_tissue(ContactTick& now) noexcept {
  double total = 0;
  for (int i = 0; i < turning.count; ++i) {
    const Turning::Hold& hold = turning.holds[static_cast<std::size_t>(i)];
    const Tissue under = model->tissue_at(now.contact.p_WG + hold.x - P::felt_below * settings.frame.voxel * hold.n);
    if (under == Tissue::kAir) continue;
    now.felt.tissue[static_cast<std::size_t>(under)] += hold.push;
    total += hold.push;
  }
  if (total > 0) now.felt.average(total, false);
}

}  // namespace typodont::haptics

// Computes the proxy: the tool's position outside the tissue that is as near to the hand as the contacts allow.
#include <algorithm>
#include <cmath>

#include "engine/base/nearest.h"
#include "haptics/contact/offset/offset_model.h"

namespace typodont::haptics::offset {

namespace {

using P = StepLimitParameters;
using Q = SearchParameters;

/// Returns how far the proxy's displacement may differ from the hand's displacement `shift`: at least `max_step`. More
/// if all points of the segment from 0 to `step` are far from `shift`, so that a stuck head can still sink.
double farthest(const dvec3& step, const dvec3& shift, double max_step) {
  return std::max(max_step, std::hypot(distance_to_segment(dvec3(0), step, shift), max_step / 2));
}

}  // namespace

void OffsetModel::constrain(const ContactInput& in, Contact& out) noexcept {
  begin_step(in);
  if (!lead_back()) {
    follow_fall(in);
    move_proxy(in);
    follow_hand();
    withdraw(in);
    watch_retreat(in);
  }
  bridge_missing_patch(in);
  report(in, out);
  if (!in.removal.cuts) emptied_ = false;
}

/// Prepares the data of the tick. Reduces the tolerated overlap of head and tissue so slowly that the force does not
/// jump while the head is moved out.
void OffsetModel::begin_step(const ContactInput& in) noexcept {
  using R = RecoveryParameters;
  Step& s = step_;
  s.allowed_depth = s.allowed_depth_at_walls = s.fall_limit = 0;
  // Separate assignments, because a chained one would read the first value back from memory.
  s.fall_normal = dvec3(0);
  s.contact_push = dvec3(0);
  s.active.count = 0;
  s.touching = s.slip_limited = s.deep = false;
  s.gap = {};
  s.c = s.start = settings_.frame.to_voxels(in.X_WG.p);
  s.target = settings_.frame.to_voxels(in.X_WT.p);
  s.shift = in.moved / voxel();
  s.overlap_before = overlap_;
  if (in.jumped) rejoining_ = 0;
  if (overlap_ > 0) overlap_ *= std::exp(-in.dt / R::recovery_time);
  s.step_per_slew = in.dt / (settings_.stiffness * std::max(in.last.relative_stiffness, 0.05)) / voxel();
  if (rejoining_ > 0) overlap_ = std::max(overlap_, s.overlap_before - P::free_slew * s.step_per_slew);
  rejoining_ = std::max(overlap_ > 0 && rejoining_ > 0 ? in.dt : 0.0, rejoining_ - in.dt);
  if (overlap_ < R::min_overlap) overlap_ = 0;
  deep_penetration_ = deep_penetration_ && overlap_ > 0;
  s.limits_step = (in.removal.cuts || tool().fill != Tissue::kAir || rejoining_ > 0) && in.last.normal_force > 0;
  if (!s.limits_step) return;
  s.cut_step = P::cut_slew * s.step_per_slew, s.free_step = P::free_slew * s.step_per_slew;
  if (surface_speed_ > 0) {
    s.cut_step = surface_speed_ * in.dt / voxel();
    s.free_step = std::max(s.free_step, s.cut_step);
  }
}

/// Limits a bur's speed when it loses its support (a fall): the tissue is gone, so the hand accelerates until the next
/// contact. A fall is detected if the tissue's push decreases while the hand gains speed against the push.
void OffsetModel::follow_fall(const ContactInput& in) noexcept {
  using F = FallParameters;
  if (!(step_.limits_step && in.removal.cuts)) {
    fall_.push_mean = dvec3(0);
    return;
  }
  const dvec3 push = in.last.normal_force * in.last.normal, v = in.moved / in.dt;
  if (fall_.push_mean == dvec3(0)) fall_.push_mean = push, fall_.hand_speed = fall_.hand_mean = v;
  const auto smooth = [&](dvec3& mean, const dvec3& is, double time) {
    mean += (is - mean) * (in.dt / (time + in.dt));
  };
  smooth(fall_.push_mean, push, F::push_time);
  smooth(fall_.hand_speed, v, F::rough_time);
  smooth(fall_.hand_mean, v, F::speed_time);
  const dvec3 gained = fall_.hand_speed - fall_.hand_mean;
  const double gain = glm::length(gained);
  // No fall if the hand's velocity changes by less than F::gain / stiffness + the noise of one encoder count.
  if (gain < F::gain / settings_.stiffness + settings_.position_step / F::rough_time) return;
  const dvec3 n = -gained / gain;
  const double held_up = glm::dot(fall_.push_mean, n);
  if (held_up < F::along * glm::length(fall_.push_mean) || glm::dot(push, n) > held_up) return;
  step_.fall_normal = n;
  const double fastest = std::max({F::landing_slew / settings_.stiffness, -F::growth * glm::dot(fall_.hand_mean, n),
                                   -glm::dot(fall_.hand_speed, n) - F::brake / settings_.stiffness});
  step_.fall_limit = fastest * in.dt / voxel();
}

/// Moves the proxy towards the hand. If the head is a ball on one smooth wall, place_ball_on_wall() computes its
/// position directly. Otherwise an iterative search moves the proxy.
void OffsetModel::move_proxy(const ContactInput& in) noexcept {
  Step& p = step_;
  contacts_.clear();
  if (in.placed && take_place(in)) return;
  bool alone = false;
  const bool seated = place_ball_on_wall(in, alone) && !slips(in);
  if (seated && alone) {
    p.active = {1, {0}, {glm::length(p.c - p.target)}};
    p.touching = true;
    wall_ = 0;
    return;
  }
  Search s;
  if (!seated || search(in, s, true) == Ending::kPlacementRefused) {
    p.c = p.start;
    search(in, s, false);
  }
  const dvec3 c = p.c;
  if (p.touching) {
    p.c = p.start + deficit_fraction(in) * (c - p.start);
    p.contact_push = (s.at_max_step ? s.held_at : c) - p.target + p.c - c;
  }
  wall_ = in.removal.cuts && settings_.boundary_walls && p.touching ? strongest_wall(p.active) : 0;
}

/// Puts the head at the place that the servo has computed. Returns false if it overlaps tissue there.
bool OffsetModel::take_place(const ContactInput& in) noexcept {
  Step& p = step_;
  if (overlap_ > 0 || !patch_.covers(p.target, reach() + 1)) return false;
  p.searched = {p.target, in.X_WT.R};
  search_around(in, p.target, false);
  for (int i = 0; i < contacts_.count(); ++i) {
    if (contacts_.approximate().gap[i] < -Q::placed_overlap) return false;
  }
  p.c = p.target;
  p.touching = true;
  wall_ = 0;
  return true;
}

/// Computes the position of a ball on one smooth wall without iterations. Returns false if this is not possible.
/// `alone`: no other tissue is near; otherwise the caller must check the position with one iteration.
bool OffsetModel::place_ball_on_wall(const ContactInput& in, bool& alone) noexcept {
  Step& p = step_;
  const bool ball = tool().shape == HeadShape::kSphere;
  if (!(ball && in.last.normal_force > 0 && !in.removal.cuts && overlap_ == 0 && !p.limits_step &&
        patch_.covers(p.start, reach() + 1))) {
    return false;
  }
  if (smooth().any() &&
      smooth().clearance(patch_, {p.start, in.X_WT.R}) <= Q::contact_range + ContactFinder::kMaxSeated) {
    return false;
  }
  return finder().seat(patch_, p.target, p.start, p.c, contacts_, alone);
}

OffsetModel::Ending OffsetModel::search(const ContactInput& in, Search& s, bool seated) noexcept {
  Step& p = step_;
  for (int iteration = 0; iteration < Q::iterations; ++iteration) {
    double head_free = 0;
    const dvec3 from = p.c;
    const Advance advance = advance_free(in, s, head_free);
    if (advance != Advance::kNear) {
      if (limit_slip(in, from) || advance == Advance::kArrived) break;
      continue;
    }

    find_contacts(in, s, head_free);
    if (seated && contacts_.deepest() > WallPlacementParameters::overlap) return Ending::kPlacementRefused;
    // The head is inside tissue; no surface is in range.
    if (contacts_.count() == 0 && sample_linear(patch_, p.c) < -Q::free_step) {
      p.deep = true;
      p.c = p.target;
      p.touching = false;
      break;
    }
    if (iteration == 0 || !p.touching) find_sink_depth(in);
    const double unfelt = rejoining_ > 0 && in.last.normal_force <= 0 ? 0 : Q::deep;
    if (iteration == 0 && contacts_.deepest() > p.overlap_before + p.allowed_depth + unfelt)
      overlap_ = contacts_.deepest();

    bool comes_free = false;
    dvec3 next = refine_and_project(in, s, project(in, s, comes_free));
    p.touching = contacts_.count() > 0;
    if (probes(in)) keep_best(s);
    if (seated) {
      const bool stays = contacts_.count() > 1 ? within_overlap_tolerance(in)
                                               : glm::length(next - p.c) < WallPlacementParameters::alone;
      return stays ? Ending::kDone : Ending::kPlacementRefused;
    }

    dvec3 step = next - p.c;
    if ((contacts_.count() == 1 || !in.removal.cuts) && p.active.count > 0 && !s.at_max_step) {
      step = extrapolate(s, step);
      next = p.c + step;
    }
    const double length = glm::length(step);
    const double longest = contacts_.count() > 1 ? Q::contact_step : Q::free_step;
    if (length > longest) {
      // In a narrow cavity, the search could alternate between two positions for ever, so it counts long steps that
      // reverse the direction of the last long step.
      s.reversals += glm::dot(step, s.long_step) < 0;
      s.long_step = step;
      if (s.reversals > Q::reversals) {
        take_best(s);
        break;
      }
      p.c += step * (longest / length);
      if (limit_slip(in, p.c - step * (longest / length))) break;
      s.last_length = 0;
      continue;
    }
    p.c = next;
    if (limit_slip(in, next - step)) break;
    if (s.at_max_step) {  // the speed limit ends the search until the next tick
      p.touching = !comes_free;
      break;
    }
    const double settled = contacts_.count() > 1 ? in.removal.cuts ? Q::settled_cutting : Q::settled : Q::converged;
    // Estimates the sum of remaining steps as a geometric series.
    const bool foreseen =
        contacts_.count() == 1 && length < s.last_length && length * length < Q::foreseen * (s.last_length - length);
    s.last_length = length;
    const int max_settled = in.removal.cuts ? Q::settling_iterations_cutting : Q::settling_iterations;
    if (length < settled || foreseen) break;
    if (++s.settled >= max_settled) {
      if (length > Q::unsettled) take_best(s);
      break;
    }
    // Without contact, the head has reached its target. With contact, the search continues; on a smooth surface, it
    // converges quadratically.
    if (p.active.count == 0) {
      p.touching = false;
      break;
    }
  }
  return Ending::kDone;
}

/// Stores the head's position if distance from the target + weighted overlap is the smallest so far.
void OffsetModel::keep_best(Search& s) const noexcept {
  const Step& p = step_;
  double overlap = 0;
  for (int i = 0; i < p.active.count; ++i)
    overlap = std::max(overlap, -contacts_.plane(p.active.index[i]).gap - overlap_);
  const double merit = glm::length(p.c - p.target) + Q::overlap_weight * overlap;
  if (merit < s.best_merit) s.best = p.c, s.best_merit = merit;
}

/// Ends a search that has not converged: moves the head to the best position found.
void OffsetModel::take_best(const Search& s) noexcept {
  if (s.best_merit < 1e300) step_.c = s.best;
}

/// Largest allowed distance between the displacements of proxy and hand in this tick, voxels, for a head that slips.
double OffsetModel::max_slip() const noexcept {
  const Step& p = step_;
  return farthest(p.c - p.start, p.shift, P::slip_slew * p.step_per_slew);
}

/// Returns true if a head that does not cut slips faster than a tool's inertia allows.
bool OffsetModel::slips(const ContactInput& in) const noexcept {
  const Step& p = step_;
  if (!probes(in) || !(in.last.normal_force > 0) || overlap_ > 0 || in.jumped) return false;
  const double slip = glm::length(p.c - p.start - p.shift);
  // The first comparison saves time: max_slip() is never smaller.
  return slip > P::slip_slew * p.step_per_slew && slip > max_slip() + Q::converged;
}

/// Limits the speed at which a head that does not cut slips relative to the hand, on tissue and in air. `from`: the
/// head's position before its last step. Returns true if the limit is reached.
bool OffsetModel::limit_slip(const ContactInput& in, const dvec3& from) noexcept {
  if (!slips(in)) return false;
  Step& p = step_;
  p.c = from + max_fraction(p.c - from, from - p.start - p.shift, max_slip()) * (p.c - from);
  p.gap.lost = p.gap.lost && !patch_.covers(p.c, reach() + 1);
  p.slip_limited = true;
  return true;
}

double OffsetModel::free_distance(const Pose& X_VT, double head_free) noexcept {
  return smooth().any() ? std::min(head_free, smooth().clearance(patch_, X_VT)) : head_free;
}

/// Moves the head towards the target by sphere tracing: a step is never longer than the distance to tissue.
OffsetModel::Advance OffsetModel::advance_free(const ContactInput& in, Search& s, double& head_free) noexcept {
  Step& p = step_;
  if (!patch_.covers(p.c, reach() + 1)) {
    p.gap.lost = true;
    return Advance::kArrived;
  }
  head_free = free_distance(p.c);
  const double free = free_distance(Pose{p.c, in.X_WT.R}, head_free);
  if (!(free > 2)) return Advance::kNear;
  p.touching = false;
  const dvec3 motion = p.target - p.c;
  const double distance = glm::length(motion);
  if (distance <= free - 1) {
    p.c = p.target;
    return Advance::kArrived;
  }
  const dvec3 next = p.c + motion * ((free - 1) / distance);
  if (!patch_.covers(next, reach() + 1)) {
    p.gap.lost = true;
    // Moves the head to the border of the tissue patch, so that the next patch is centred farther ahead; otherwise a
    // fast head would never advance.
    p.c += motion * std::min((free - 1) / distance, patch_.held_fraction(p.c, motion, reach() + 1));
    return Advance::kArrived;
  }
  p.c = next;
  s.last_length = 0;
  return Advance::kOn;
}

/// Finds the contacts of the head at step_.c. Usually searches again. Only updates the last contacts if there are
/// several, the head is a ball or cuts, has moved little, and is neither deep in tissue nor in a groove.
void OffsetModel::find_contacts(const ContactInput& in, Search& s, double head_free) noexcept {
  const dvec3& c = step_.c;
  const bool ball = tool().shape == HeadShape::kSphere;
  if (!ball || smooth().any()) step_.searched = {c, in.X_WT.R};
  if (contacts_.count() > 1 && (in.removal.cuts || ball) && !contacts_.deep_penetration() && !contacts_.flat() &&
      glm::length(c - s.found_at) < Q::reuse_distance) {
    contacts_.drop_added();
    finder().relinearize({c, in.X_WT.R}, contacts_);
    if (smooth().any()) smooth().relinearize({c, in.X_WT.R}, contacts_);
  } else {
    search_around(in, c, head_free + reach() < 0);
    s.found_at = c;
  }
}

/// Searches the contacts of head, shank and safe end (pin at the tip), with the head's centre at c.
void OffsetModel::search_around(const ContactInput& in, const dvec3& c, bool center_inside) noexcept {
  const Pose X_VT{c, in.X_WT.R};
  finder().find(patch_, X_VT, Q::contact_range, contacts_, only_touches(in));
  deep_penetration_ =
      contacts_.deepest() > (deep_penetration_ ? Q::led_out : ContactFinder::kDeepPenetration) || center_inside;
  if (deep_penetration_) {
    finder().find_way_out(patch_, X_VT, contacts_);
  } else if (in.removal.cuts && (emptied_ || surface_speed_ > 0) && !in.removal.must_earn) {
    finder().project_out({step_.start, in.X_WG.R}, X_VT, contacts_);
  }
  // On harder tissue than the tissue being cut, a contact allows only the fraction softer / harder energy of the depth.
  if (settings_.boundary_walls && in.removal.specific_energy > 0 && in.removal.specific_energy < hardest_) {
    for (int i = 0; i < contacts_.count(); ++i) {
      const double under = specific_energy_at(contacts_.below(i));
      if (under > in.removal.specific_energy) contacts_.set_yields(i, in.removal.specific_energy / under);
    }
  }
  if (smooth().any()) smooth().find(patch_, X_VT, Q::contact_range, contacts_);
  step_.active = guess_active(contacts_, held_);
}

/// Returns the position nearest to the target that contacts and speed limit allow.
dvec3 OffsetModel::project(const ContactInput& in, Search& s, bool& comes_free) noexcept {
  Step& p = step_;
  s.led_to = p.target;
  dvec3 next = nearest_allowed(contacts_, p.c, overlap_, p.allowed_depth, s.led_to, p.active);
  s.held_at = next;
  comes_free = p.active.count == 0;
  // When the bur loses its support, an additional plane under the head, sinking at the allowed speed, limits its speed.
  const bool falls = p.fall_normal != dvec3(0) && glm::dot(next - p.start, p.fall_normal) < -p.fall_limit &&
                     contacts_.add({p.c, p.fall_normal, glm::dot(p.c - p.start, p.fall_normal) + p.fall_limit});
  if (falls) next = nearest_allowed(contacts_, p.c, overlap_, p.allowed_depth, s.led_to, p.active);
  const double max_step = comes_free ? p.free_step : p.cut_step;
  const double allowed = p.limits_step ? farthest(next - p.start, p.shift, max_step) : 0;
  s.at_max_step = falls || (p.limits_step && glm::length(next - p.start - p.shift) > P::tolerance * allowed);
  const bool eases = in.removal.cuts || tool().fill != Tissue::kAir;
  if (s.at_max_step && eases && (falls || !comes_free)) s.led_to = ease(p.start + p.shift, allowed, s.led_to, next);
  return next;
}

/// Computes the exact plane of the contact with the smallest gap at `next`. Its approximate plane may miss a bump
/// narrower than the distance between the head's samples. Returns true if the plane changed.
bool OffsetModel::refine_nearest(const ContactInput& in, const dvec3& next) noexcept {
  int nearest = -1;
  double least = Q::may_block;
  for (int i = 0; i < contacts_.own(); ++i) {
    const ContactPlane plane = contacts_.plane(i);
    const double gap = plane.gap + glm::dot(next - step_.c, plane.n);
    if (gap < least) least = gap, nearest = i;
  }
  return nearest >= 0 && finder().refine(patch_, {step_.c, in.X_WT.R}, contacts_, nearest, true);
}

/// Computes the exact planes of the contacts that stop the head, and then the nearest allowed position. Repeats both,
/// because other contacts may stop the head at the new position.
dvec3 OffsetModel::refine_and_project(const ContactInput& in, Search& s, dvec3 next) noexcept {
  Step& p = step_;
  if (probes(in) && p.active.count == 0 && refine_nearest(in, next))
    next = nearest_allowed(contacts_, p.c, overlap_, p.allowed_depth, s.led_to, p.active);
  const int rounds = in.removal.cuts ? 1 : Q::refining_rounds;
  const int least = only_touches(in) ? 0 : 1;  // a cutting or filling head's single contact is not refined
  for (int round = 0; round < rounds && contacts_.count() > least && p.active.count > 0; ++round) {
    bool refined = false;
    for (int i = 0; i < p.active.count; ++i) {
      refined |= finder().refine(patch_, {p.c, in.X_WT.R}, contacts_, p.active.index[i], !in.removal.cuts);
    }
    if (!refined) break;
    next = nearest_allowed(contacts_, p.c, overlap_, p.allowed_depth, s.led_to, p.active);
  }
  // At the border to harder tissue (Wang 2009), a bur uses this fraction of its power: softer / harder specific energy.
  const bool walled = in.removal.cuts && settings_.boundary_walls;
  for (int round = 0; walled && p.allowed_depth > 0 && round < WallParameters::rounds &&
                      hold_at_walls(p.active, p.allowed_depth_at_walls);
       ++round) {
    next = nearest_allowed(contacts_, p.c, overlap_, p.allowed_depth, s.led_to, p.active);
  }
  return next;
}

/// Lengthens the step (secant method). On a smooth curved surface, successive steps form a geometric series; a step of
/// the length of their sum replaces them. With several blocking contacts, the method only shortens the step. The
/// component towards the tissue does not change.
dvec3 OffsetModel::extrapolate(Search& s, const dvec3& step) noexcept {
  const Step& p = step_;
  const double before2 = glm::dot(s.last_step, s.last_step);
  const double fraction = before2 > 0 ? glm::dot(step, s.last_step) / before2 : 0;
  const double most = p.active.count > 1 ? 1 : contacts_.count() > 1 ? Q::max_gain_of_many : Q::max_gain;
  s.last_step = step;
  s.last_gain = fraction != 0 && fraction < Q::still_converges ? std::min(s.last_gain / (1 - fraction), most) : 1;
  dvec3 n(0);
  for (int i = 0; i < p.active.count; ++i) n += p.active.push[i] * contacts_.plane(p.active.index[i]).n;
  n = glm::normalize(n);
  return step + (s.last_gain - 1) * (step - glm::dot(step, n) * n);
}

/// Computes how deep the head may sink in this tick. The energy budget limits the removed volume: contact area × depth,
/// plus a spherical cap because the contact grows.
void OffsetModel::find_sink_depth(const ContactInput& in) noexcept {
  if (!(in.removal.budget > 0 && in.removal.specific_energy > 0)) return;
  const double h = voxel();
  const double area = glm::length(contacts_.engaged_normal());
  const double cap = kPi * tool().radius() / h;
  const auto bought_by = [&](double energy) {
    const double volume = std::max(energy, 0.0) / in.removal.specific_energy / (h * h * h);
    return volume > 0 ? std::min(2 * volume / (area + std::sqrt(area * area + 4 * cap * volume)), Q::max_allowed_depth)
                      : 0.0;
  };
  step_.allowed_depth = bought_by(in.removal.budget);
  step_.allowed_depth_at_walls = bought_by(std::min(in.removal.wall_budget, in.removal.budget)) / step_.allowed_depth;
}

/// Fraction 0..1 of its step that a bur may make. A bur whose cuts have used more energy than the motor delivered is
/// slowed down while it is pressed into tissue.
double OffsetModel::deficit_fraction(const ContactInput& in) const noexcept {
  const Step& p = step_;
  if (!(emptied_ && in.removal.budget < 0 && in.removal.cuts && glm::dot(p.target - p.start, in.last.normal) < 0)) {
    return 1;
  }
  return std::clamp(
      (P::standing_deficit + in.removal.budget / in.removal.power) / (P::standing_deficit - P::free_deficit), 0.0, 1.0);
}

/// Call after a ball was placed on one wall. Returns true if the ball overlaps no active contact plane by more than a
/// tolerance. Planes of this wall and other planes have different tolerances.
bool OffsetModel::within_overlap_tolerance(const ContactInput& in) const noexcept {
  using S = WallPlacementParameters;
  for (int i = 0; i < step_.active.count; ++i) {
    const ContactPlane plane = contacts_.plane(step_.active.index[i]);
    if (plane.gap < (glm::dot(plane.n, in.last.normal) > S::same_wall ? -S::same_wall_overlap : -S::other_wall)) {
      return false;
    }
  }
  return true;
}

/// Limits the change of the force. `next`: position at which the contacts hold the head. Moves the target from
/// `pulled_to` towards `carried` until |next - carried| <= `most`. Returns the moved target; updates `next`.
dvec3 OffsetModel::ease(const dvec3& carried, double most, const dvec3& pulled_to, dvec3& next) noexcept {
  double fraction = 1;
  dvec3 led_to = pulled_to;
  for (int round = 0; round < P::rounds; ++round) {
    const double away = glm::length(next - carried);
    if (away <= P::tolerance * most) break;
    fraction *= most / away;
    led_to = carried + fraction * (pulled_to - carried);
    next = nearest_allowed(contacts_, step_.c, overlap_, step_.allowed_depth, led_to, step_.active);
  }
  return led_to;
}

/// Fraction of its power with which the head cuts at this contact plane. At a wall (the head comes from much softer
/// tissue): specific energy of the softer tissue / that of the harder tissue. Elsewhere: 1.
double OffsetModel::wall_at(const ContactPlane& plane) const noexcept {
  using W = WallParameters;
  const dvec3 before = plane.x + (W::felt_depth / voxel() + W::border) * plane.n, behind = plane.x - 0.5 * plane.n;
  if (!patch_.holds(before, 0) || !patch_.holds(behind, 0)) return 1;
  const double softer = specific_energy_at(before), harder = specific_energy_at(behind);
  return softer > 0 && softer < W::from_ratio * harder ? std::max(softer / harder, W::min_power) : 1;
}

/// Smallest wall_at() of all planes that stop the head; 0 if none of them is a wall.
double OffsetModel::strongest_wall(const ActivePlanes& active) const noexcept {
  double least = 1;
  for (int i = 0; i < active.count; ++i) {
    if (active.index[i] < contacts_.own()) least = std::min(least, wall_at(contacts_.plane(active.index[i])));
  }
  return least < 1 ? least : 0;
}

/// Limits ContactPlane::yields (the fraction of the depth that a plane allows) to `yields`, for all planes that hold
/// the head and lie at a wall. Returns true if a value was reduced.
bool OffsetModel::hold_at_walls(const ActivePlanes& active, double yields) noexcept {
  bool changed = false;
  for (int i = 0; i < active.count; ++i) {
    const int index = active.index[i];
    const ContactPlane plane = contacts_.plane(index);
    if (index >= contacts_.own() || plane.yields <= yields || wall_at(plane) == 1) continue;
    contacts_.set_yields(index, yields);
    changed = true;
  }
  return changed;
}

/// Limits the proxy's speed relative to the hand, so that the force changes slowly when contacts change or end. The
/// limit can only make the proxy lag behind the hand, so it dissipates energy.
void OffsetModel::follow_hand() noexcept {
  Step& p = step_;
  const bool at_max_step = p.limits_step && !p.deep;
  breaking_through_ = (at_max_step || p.slip_limited) && !p.touching;
  if (!at_max_step) return;
  const dvec3 step = p.c - p.start;
  const double max_step = breaking_through_ ? p.free_step : p.cut_step;
  p.c = p.start + max_fraction(step, -p.shift, farthest(step, p.shift, max_step)) * step;
  p.gap.lost = p.gap.lost && !patch_.covers(p.c, reach() + 1);
}

/// Leads a trapped proxy back along its recorded path. Returns true if it is led back in this tick.
bool OffsetModel::lead_back() noexcept {
  Step& p = step_;
  if (!retreat_.lead(p.target, RetreatParameters::slew * p.step_per_slew, p.c)) return false;
  contacts_.clear();
  overlap_ = wall_ = 0;
  fall_.push_mean = dvec3(0);
  rejoining_ = RecoveryParameters::rejoin_time;  // the proxy's speed is limited during this time
  breaking_through_ = true;
  return true;
}

/// Moves a bur that does not cut at present, but is held in its own cut, back along its path towards the hand.
void OffsetModel::withdraw(const ContactInput& in) noexcept {
  Step& p = step_;
  if (in.removal.cuts || !p.touching || p.deep || p.gap.lost || !has_cut_) return;
  if (tool().shape != HeadShape::kSphere && RetreatPath::turned(in.X_WT.R, cut_end_.R)) return;
  p.c = retreat_.path.withdrawn(p.c, p.target, RetreatParameters::slew * p.step_per_slew + glm::length(p.shift));
}

/// Records the path of a cutting tool. Detects that the hand has moved away while the contacts still hold the proxy.
void OffsetModel::watch_retreat(const ContactInput& in) noexcept {
  retreat_.wedged = false;
  const Step& p = step_;
  if (!settings_.cutting || !tool().cuts || p.gap.lost || p.deep) return;
  const bool outside = !p.touching && free_distance(p.c) * voxel() > RetreatParameters::outside;
  has_cut_ = !outside && (has_cut_ || emptied_);
  if (retreat_.is_held(p.c, p.target, outside, in.dt) && hand_has_left()) retreat_.begin(p.c, p.target);
}

/// Returns true if the hand has moved away: either the line from the proxy to the hand contains a place where the head
/// would not touch tissue, or the hand is too far away to be pressing.
bool OffsetModel::hand_has_left() const noexcept {
  using R = RetreatParameters;
  const Step& p = step_;
  const dvec3 motion = p.target - p.c;
  const double length = glm::length(motion);
  if (length * voxel() > R::too_far) return true;
  for (double s = reach(); s < length; s += R::search_step) {
    const dvec3 x = p.c + motion * (s / length);
    if (patch_.covers(x, 1)) {
      if (free_distance(x) > 1) return true;
      continue;
    }
    if (patch_.coarse_levels.empty()) return false;
    // Coarse samples are `every` voxels apart, so a place is free only if the head there is `every` away from tissue.
    const TissuePatch& coarse = patch_.coarse_levels.front();
    const double every = coarse.every;
    if (!coarse.covers(x / every, 1)) return false;
    if (sample_linear(coarse, x / every) * every - reach() > every) return true;
  }
  return false;
}

/// Replaces tissue outside the tissue patch by a plane, until a new patch arrives.
void OffsetModel::bridge_missing_patch(const ContactInput& in) noexcept {
  Step& p = step_;
  if (!missing_.bridge(in, {voxel(), 1, glm::length(p.c - p.start), p.start, p.target, p.step_per_slew}, p.c, p.gap))
    return;
  if (!p.gap.bridging) overlap_ = 0;
  p.touching = breaking_through_ = false;
  rejoining_ = RecoveryParameters::rejoin_time;
  contacts_.clear();
  p.active.count = 0;
}

int OffsetModel::near_planes(std::span<NearPlane, kMaxNearPlanes> planes) const noexcept {
  const Step& p = step_;
  if (p.deep || deep_penetration_) return 0;
  const ApproximatePlanes& near = contacts_.approximate();
  const double h = voxel();
  const dvec3 moved = p.c - p.searched.p, origin = contacts_.origin() - p.c;
  for (int i = 0; i < contacts_.count(); ++i) {
    const dvec3 n(near.nx[i], near.ny[i], near.nz[i]);
    planes[static_cast<std::size_t>(i)] = {h * (origin + dvec3(near.x[i], near.y[i], near.z[i])), n,
                                           h * (static_cast<double>(near.gap[i]) + glm::dot(n, moved))};
  }
  return contacts_.count();
}

bool OffsetModel::refine_near_plane(int i) noexcept {
  return finder().refine(patch_, step_.searched, contacts_, i, true);
}

void OffsetModel::report(const ContactInput& in, Contact& out) noexcept {
  const Step& p = step_;
  held_.count = 0;
  if (p.touching) held_by(contacts_, p.active, held_);
  out.p_WG = p.c == p.target ? in.X_WT.p : settings_.frame.to_world(p.c);
  out.touching = p.touching;
  out.breaking_through = breaking_through_;
  out.deep = p.deep;
  out.gap = p.gap;
  out.gap.rejoining = rejoining_ > 0;
  out.leading_out = overlap_ > 0;
  out.settled = overlap_ == 0 && rejoining_ == 0 && !retreat_.leading;
  out.contact_direction = p.contact_push;
  out.wall.share = wall_;
  // The contact area is measured on the samples of the head's surface. With a single exact contact there are no
  // samples, so the area is estimated for a ball on a plane.
  if (p.touching && contacts_.own() > 0) {
    const double h = voxel();
    out.area = contacts_.engaged_area() > 0 ? contacts_.engaged_area() * h * h : kPi * tool().radius() * h;
  }
  if (retreat_.wedged || retreat_.leading) out.faults |= bits(Fault::kWedged);
}

}  // namespace typodont::haptics::offset

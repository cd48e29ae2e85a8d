// The proxy: where the tool is held, outside the tissue, as near to the hand as its contacts allow.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kContactRange = 0.8;  // contacts farther away than this do not matter yet …
constexpr double kContactStep = 0.6;   // … because a step among several is no longer than this
constexpr double kStep = 1.5;          // longest step between two looks at the contacts: nothing thinner is skipped
constexpr double kConverged = 1e-6;    // the proxy has come to rest,
constexpr double kForeseen = 1e-7;     // … or will have, within this
constexpr double kSettled = 2e-5;      // the same where several contacts were looked at,
constexpr double kSettledCutting =
    0.03;  // … and while they are cut: so far on they still serve, but for the square of it
constexpr int kSettlingLooks = 8, kSettlingLooksCutting = 5;
constexpr int kRefiningRounds = 6;        // of a head that does not cut
constexpr double kStillConverges = 0.95;  // share that a step may be of the one before …
constexpr double kMostGain = 10;          // … and how many steps may be made at once,
constexpr double kMostGainOfMany = 2;     // … of several contacts
// A ball lies where its wall says that it does, unless it overlaps tissue there by so many voxels, however roughly that
// was found, …
constexpr double kNoSeat = 0.1;
constexpr double kSeated = 4e-3;                        // … other walls by so many, …
constexpr double kSameWall = 0.9, kSeatedAlong = 0.02;  // … its own beside there, which normals tell by their cosine, …
constexpr double kSeatedAlone = 2e-4;                   // … or a single exact contact moves it by so many
constexpr double kSamePoints = 0.3;      // contacts found less than this ago, in voxels of way, still serve
constexpr double kToothGrip = 0.15;      // engaged teeth resist being led sideways up to this share of the push
constexpr double kMostSlack = 1.0;       // deeper in one tick the surface that was found says nothing
constexpr int kMaxLooks = 48;            // per tick, free flight included
constexpr double kDeep = 0.6;            // more overlap than cutting or rounding leaves: led out slowly
constexpr double kRecoveryTime = 0.006;  // s, time constant of leading the tool out of tissue
constexpr double kCutSlew = 6;           // N/s, no faster does the proxy change the force of a cutting contact, …
constexpr double kPaceTold = 1.02;       // … told so exactly, …
constexpr int kPaceRounds = 4;           // … or in so many steps
constexpr double kGripSlew = 9;          // N/s, no faster does the force rise when the teeth catch
constexpr double kRoughTime = 2e-3;      // s of a hand's ways that its speed now is told from, …
constexpr double kSpeedTime = 0.1;       // … and that of late, …
constexpr double kPushTime = 0.05;       // … and what held it up of late
constexpr double kFallGain = 5;          // N/s that the speed gained by a hand which falls is worth, …
constexpr double kFallsAlong = 0.3;      // … along the push of late, by the cosine
constexpr double kLandingSlew = 12;      // N/s: as fast may a bur land, or faster than the hand went of late by …
constexpr double kFallGrowth = 1.2;      // … this factor, …
constexpr double kFallBrake = 12;        // N/s, … or slower than it falls by this, which it feels
constexpr double kFreeDebt = 0.003;  // s of the motor's work that a bur may have cut in advance; it goes slower then, …
constexpr double kStandingDebt = 0.012;  // … and stands
constexpr double kWallFelt =
    0.1e-3;                      // m that a head may have got into harder tissue, and still meets the wall before it
constexpr double kBorder = 0.5;  // voxels that show either tissue on both sides of where one ends
constexpr double kLeastThrough = 0.1;  // of the power that it cuts with there
constexpr double kWallFrom =
    0.2;                        // softer over harder, above which there is no wall: a bur leads from caries into dentin
constexpr int kWallRounds = 4;  // planes that hold in place of such as give way
constexpr double kPatchWait = 0.01;    // s that the tool waits where its patch ends before it counts as late
constexpr double kBridgeReach = 5e-3;  // m from where the field ended that the last contact's plane stands in for it
constexpr double kBridgeYield = 0.5;   // N beyond the push of that contact, at which the plane gives way
constexpr double kRejoinTime = 0.3;    // s for finding back from there to the surface without a step

/// A turning head that is pressed into tissue stays where it is until the hand leads it sideways by more than the teeth
/// grip (a friction cone on the god-object): roughness of the cut surface then does not shake the hand. Returns the
/// target as if that grip held back its tangential part. `moved`: the hand since the last tick. The lag sideways grows
/// by `most` at most, so that teeth which catch do not stop the head dead.
dvec3 held_target(const dvec3& from, const dvec3& target, const dvec3& n, const dvec3& moved, double most) {
  const dvec3 pull = from - target;
  const double pushed = glm::dot(pull, n);
  if (!(pushed > 0)) return target;
  const dvec3 sideways = pull - pushed * n;
  const double length = glm::length(sideways);
  const dvec3 lag = sideways * (length > kToothGrip * pushed ? kToothGrip * pushed / length : 1.0);
  const dvec3 change = lag - (sideways + moved - glm::dot(moved, n) * n);  // since the last tick
  const double size = glm::length(change);
  if (size > most && glm::dot(change, lag) > 0) return target + lag - change * (1 - most / size);
  return target + lag;
}

/// How far from where the hand would have carried it by `shift` a proxy may end that would make `step`: `pace`, or
/// hardly more than it must: a hand that is fast beside a head stuck in its hole does not keep it from sinking.
double farthest(const dvec3& step, const dvec3& shift, double pace) {
  const double length2 = glm::dot(step, step);
  const double nearest = length2 > 0 ? std::clamp(glm::dot(step, shift) / length2, 0.0, 1.0) : 0.0;
  return std::max(pace, std::hypot(glm::length(nearest * step - shift), pace / 2));
}

}  // namespace

double largest_share(const dvec3& step, const dvec3& rest, double most) {
  const double a = glm::dot(step, step), b = -glm::dot(step, rest),
               d = b * b - a * (glm::dot(rest, rest) - most * most);
  return a > 0 ? std::clamp((b + std::sqrt(std::max(d, 0.0))) / a, 0.0, 1.0) : 1.0;
}

bool Servo::State::would_be_free(std::uint32_t which, const Pose& X_VT) noexcept {
  const ContactFinder& other = tools[which].finder;
  SmoothContacts& parts = tools[which].smooth;
  const double far = tools[which].reach;
  if (!patch.holds(X_VT.p, far + 1)) return false;
  const double distance = sample_linear(patch, X_VT.p);
  parts.forget();
  if (distance > far + 2 && parts.room(patch, X_VT) > kContactRange) return true;
  if (distance <= 0) return false;
  other.find(patch, X_VT, kContactRange, contacts);
  if (parts.any()) parts.find(patch, X_VT, kContactRange, contacts);
  for (int i = 0; i < contacts.count(); ++i) {
    if (contacts.plane(i).gap <= 0) return false;
  }
  return true;
}

bool Servo::State::fly(Now& now) noexcept {
  const Tool& head = tool();
  ServoTick& out = now.out;
  if (!idle || ending || head.fill != Tissue::kAir || settings.filter != ForceFilter::kNone ||
      (settings.vibration.band > 0 && speed > 0)) {
    return false;
  }
  const double way = glm::length(now.X_WT.p - X_WG.p) / settings.frame.voxel;
  // What was free around the last place is so around the next, less the way there: looked at only when that runs out.
  if (!(room_around > 1 && way <= room_around)) {
    const dvec3 c = settings.frame.to_voxels(X_WG.p);
    if (!patch.holds(c, reach() + 1)) return false;
    room_around = std::min(clearance(c), patch.reach_around(c) - reach() - 1) - 1;
    if (smooth().any()) room_around = std::min(room_around, smooth().room(patch, {c, now.X_WT.R}) - 1);
    if (!(room_around > 1 && way <= room_around)) return false;
  }
  room_around = smooth().any() ? 0 : room_around - way;  // those keep account of their room themselves, turns included

  due_for = patch_due_for(now.X_WT.p, patch.center_W, travel) ? due_for + now.dt : 0;
  out.faults = due_for > kStaleTime ? bits(Fault::kStalePatch) : 0;
  lost_for = 0;
  breaking_through = carved = false;
  held.count = 0;
  budget = std::min(budget, 0.0);  // a free head has earned nothing
  wall_budget = 0;
  ramp = 1;
  given = std::clamp(-sums.energy, 0.0, sums.energy < -kDebt ? -sums.energy : given);
  if (settings.position_step > 0) depth_speed.add(now.hand.t, dvec3(0));
  if (settings.passivity) {
    passive_share(passivity_law, dvec3(0), now.moved, dvec3(0), now.turned, now.dt, settings.tick, sums.energy + given,
                  passivity);
  }
  last_hand = X_WG = out.X_WG = now.X_WT;
  last_t = now.hand.t;
  now.cut.n_C_W = dvec3(0);
  out.spindle = speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  return true;
}

/// What overlap there is is led out of the tissue, as fast as the hand may feel it.
void Servo::State::lead_out(Touch& now) noexcept {
  now.overlap_before = overlap;
  if (overlap > 0) overlap *= std::exp(-now.dt / kRecoveryTime);
  now.pace_per_slew =
      now.dt / (settings.stiffness * std::max(stiffness_share, 0.05)) / settings.frame.voxel;  // voxels per N/s
  if (rejoining > 0) overlap = std::max(overlap, now.overlap_before - kFreeSlew * now.pace_per_slew);
  rejoining = std::max(overlap > 0 && rejoining > 0 ? now.dt : 0.0, rejoining - now.dt);
  if (overlap < 0.01) overlap = 0;
  now.paced = (now.may_cut || tool().fill != Tissue::kAir || rejoining > 0) && normal_force > 0;
  now.carried = (X_WG.p - last_hand.p) / settings.frame.voxel;
}

/// Where its support gives way, a hand falls, and lands at the speed that it has gained: what it goes in a tick is then
/// felt as a step. So a bur that holds the hand up less than of late, while the hand goes against that push ever
/// faster, sinks no faster than it may land. A hand that draws the bur on at a steady speed does not fall, however
/// steep its way.
void Servo::State::follow_fall(Touch& now) noexcept {
  if (!(now.paced && now.may_cut && !now.scrapes)) {
    push_mean = dvec3(0);
    return;
  }
  const dvec3 push = normal_force * normal, v = now.moved / now.dt;
  if (push_mean == dvec3(0)) push_mean = push, hand_speed = hand_mean = v;
  const auto smooth = [&](dvec3& mean, const dvec3& is, double time) {
    mean += (is - mean) * (now.dt / (time + now.dt));
  };
  smooth(push_mean, push, kPushTime);
  smooth(hand_speed, v, kRoughTime);
  smooth(hand_mean, v, kSpeedTime);
  const dvec3 gained = hand_speed - hand_mean;
  const double gain = glm::length(gained);
  if (gain < kFallGain / settings.stiffness + settings.position_step / kRoughTime) return;  // a count alone is no fall
  const dvec3 n = -gained / gain;
  const double held_up = glm::dot(push_mean, n);
  if (held_up < kFallsAlong * glm::length(push_mean) || glm::dot(push, n) > held_up) return;
  now.falls_n = n;
  const double fastest = std::max({kLandingSlew / settings.stiffness, -kFallGrowth * glm::dot(hand_mean, n),
                                   -glm::dot(hand_speed, n) - kFallBrake / settings.stiffness});
  now.falls = fastest * now.dt / settings.frame.voxel;
}

/// Where the head comes from softer tissue and stands before much harder, the share of its power that it cuts with:
/// softer over harder specific energy; else 1.
double Servo::State::wall_at(const ContactPlane& plane) const noexcept {
  const dvec3 before = plane.x + (kWallFelt / settings.frame.voxel + kBorder) * plane.n,
              behind = plane.x - 0.5 * plane.n;
  if (!patch.holds(before, 0) || !patch.holds(behind, 0)) return 1;
  const auto energy_at = [&](const dvec3& p) {
    return settings.materials[static_cast<std::size_t>(tissue_at(patch, p))].specific_energy;
  };
  const double softer = energy_at(before), harder = energy_at(behind);
  return softer > 0 && softer < kWallFrom * harder ? std::max(softer / harder, kLeastThrough) : 1;
}

/// The least such share of what holds the head; 0 where no wall does.
double Servo::State::wall_of(const ActivePlanes& active) const noexcept {
  double least = 1;
  for (int i = 0; i < active.count; ++i) {
    if (active.index[i] < contacts.own()) least = std::min(least, wall_at(contacts.plane(active.index[i])));
  }
  return least < 1 ? least : 0;
}

/// Lets those of the holding planes that lie in a wall give way by `yields` at most. Whether any did by more before.
bool Servo::State::hold_at_walls(const ActivePlanes& active, double yields) noexcept {
  bool changed = false;
  for (int i = 0; i < active.count; ++i) {
    const int index = active.index[i];
    const ContactPlane plane = contacts.plane(index);
    if (index >= contacts.own() || plane.yields <= yields || wall_at(plane) == 1) continue;
    contacts.set_yields(index, yields);
    changed = true;
  }
  return changed;
}

/// Finds all that the head and the smooth parts touch at c, voxels.
void Servo::State::look_around(Touch& now, const dvec3& c, bool center_inside) noexcept {
  const Pose X_VT{c, now.X_WT.R};
  finder().find(patch, X_VT, kContactRange, contacts);
  if (contacts.deepest() > ContactFinder::kSunk || center_inside) {
    finder().find_way_out(patch, X_VT, contacts);
  } else if (now.may_cut && carved && !now.in_debt) {
    finder().forgive({now.c0, X_WG.R}, X_VT, contacts);
  }
  // Tissue harder than what is being cut gives way by that much less; softer tissue never holds anything back.
  if (settings.boundary_walls && now.specific_energy > 0 && now.specific_energy < hardest) {
    for (int i = 0; i < contacts.count(); ++i) {
      const auto under = static_cast<std::size_t>(tissue_at(patch, contacts.below(i)));
      const double hardness = settings.materials[under].specific_energy;
      if (hardness > now.specific_energy) contacts.set_yields(i, now.specific_energy / hardness);
    }
  }
  if (smooth().any()) smooth().find(patch, X_VT, kContactRange, contacts);
  now.active = guess_active(contacts, held);
}

/// How far the head may sink in this tick: the budget buys area × depth + the cap of a first touch.
void Servo::State::find_room_to_sink(Touch& now) const noexcept {
  if (!(budget > 0 && now.specific_energy > 0)) return;
  const double h = settings.frame.voxel;
  const double area = glm::length(contacts.engaged_normal());
  const double cap = kPi * tool().radius() / h;
  const auto bought_by = [&](double energy) {
    const double volume = std::max(energy, 0.0) / now.specific_energy / (h * h * h);
    return volume > 0 ? std::min(2 * volume / (area + std::sqrt(area * area + 4 * cap * volume)), kMostSlack) : 0.0;
  };
  now.slack = bought_by(budget);
  now.slack_at_walls = bought_by(std::min(wall_budget, budget)) / now.slack;
}

/// The share of its way, 0..1, that a bur may go which has cut more than its motor has worked for: it waits until that
/// is paid, as long as it is pushed. So does a sharp rim in a pit too shallow for its wall to be felt.
double Servo::State::share_in_debt(const Touch& now) const noexcept {
  if (!(carved && budget < 0 && now.may_cut && !now.scrapes && glm::dot(now.target - now.c0, normal) < 0)) return 1;
  return std::clamp((kStandingDebt + budget / now.spindle.power) / (kStandingDebt - kFreeDebt), 0.0, 1.0);
}

/// Whether none of the planes that hold a ball where its wall says that it lies is another wall in its way.
bool Servo::State::nothing_in_the_way(const Touch& now) const noexcept {
  for (int i = 0; i < now.active.count; ++i) {
    const ContactPlane plane = contacts.plane(now.active.index[i]);
    if (plane.gap < (glm::dot(plane.n, normal) > kSameWall ? -kSeatedAlong : -kSeated)) return false;
  }
  return true;
}

/// A bur that must let the hand feel no step goes to the place nearest to the hand among those no farther than `most`
/// from where the hand would carry it. That is where contacts hold it when it is led to a point on the way from there
/// to the hand: what it lags by shrinks along itself, so that a bur which comes out over a rim lands, and then catches
/// up. Takes `next` there, from where contacts alone would hold it, and returns that point.
dvec3 Servo::State::ease(Touch& now, const dvec3& c, const dvec3& carried, double most, const dvec3& pulled_to,
                         dvec3& next) const noexcept {
  double share = 1;
  dvec3 led_to = pulled_to;
  for (int round = 0; round < kPaceRounds; ++round) {
    const double away = glm::length(next - carried);
    if (away <= kPaceTold * most) break;
    share *= most / away;
    led_to = carried + share * (pulled_to - carried);
    next = nearest_allowed(contacts, c, overlap, now.slack, led_to, now.active);
  }
  return led_to;
}

void Servo::State::move_proxy(Touch& now) noexcept {
  const ContactFinder& head = finder();
  SmoothContacts* const smooth_parts = smooth().any() ? &smooth() : nullptr;
  const bool ball = tool().shape == HeadShape::kSphere;
  const dvec3 c0 = now.c0 = settings.frame.to_voxels(X_WG.p),
              target = now.target = settings.frame.to_voxels(now.X_WT.p);
  dvec3 c = c0;
  contacts.clear();
  room_around = 0;  // what is found from here on holds for this place alone
  int settled_looks = 0;
  dvec3 found_at(0), last_step(0);
  double last_gain = 1, last_length = 0;
  lead_out(now);
  follow_fall(now);
  const bool walled = now.may_cut && settings.boundary_walls;
  const dvec3 shift = now.moved / settings.frame.voxel;
  bool at_a_pace = false;
  dvec3 held_at(0);  // by contacts alone, where the pace keeps the head from there

  // A ball that slides along one smooth wall needs no search: the wall says where it will lie. Where more of the tissue
  // is near, a look shows whether that is in the way.
  bool seated = false;
  if (ball && normal_force > 0 && !now.may_cut && overlap == 0 && !now.paced && patch.holds(c0, reach() + 1) &&
      !(smooth_parts && smooth_parts->room(patch, {c0, now.X_WT.R}) <= kContactRange + ContactFinder::kMostSeated)) {
    bool alone = false;
    seated = head.seat(patch, target, c0, c, contacts, alone);
    if (alone) {
      now.active = {1, {0}, {glm::length(c - target)}};
      now.touching = true;
      now.c = c;
      wall = 0;
      return;
    }
  }

  for (int look = 0; look < kMaxLooks; ++look) {
    if (!patch.holds(c, reach() + 1)) {
      now.lost = true;
      break;
    }
    const double head_free = clearance(c);
    const double free = smooth_parts ? std::min(head_free, smooth_parts->room(patch, {c, now.X_WT.R})) : head_free;
    if (free > 2) {  // sphere tracing: as far as nothing can be met
      now.touching = false;
      const dvec3 way = target - c;
      const double distance = glm::length(way);
      if (distance <= free - 1) {
        c = target;
        break;
      }
      const dvec3 next = c + way * ((free - 1) / distance);
      if (!patch.holds(next, reach() + 1)) {
        now.lost = true;
        break;
      }
      c = next;
      last_length = 0;
      continue;
    }

    // The surface points found once serve as long as the head has hardly moved; a single exact one is always new, and
    // so are those around a rim, which are told from the rough ones by queries.
    if (contacts.count() > 1 && (now.may_cut || ball) && !contacts.sunk() && !contacts.flat() &&
        glm::length(c - found_at) < kSamePoints) {
      contacts.drop_added();
      head.relinearize({c, now.X_WT.R}, contacts);
      if (smooth_parts) smooth_parts->relinearize({c, now.X_WT.R}, contacts);
    } else {
      look_around(now, c, head_free + reach() < 0);
      found_at = c;
    }
    if (seated && contacts.deepest() > kNoSeat) {
      c = c0, look = -1, seated = false;
      continue;
    }
    if (contacts.count() == 0 && sample_linear(patch, c) < -kStep) {  // wholly inside: no surface in reach
      now.deep = true;
      c = target;
      now.touching = false;
      break;
    }
    if (look == 0 || !now.touching) find_room_to_sink(now);
    const double unfelt = rejoining > 0 && normal_force <= 0 ? 0 : kDeep;
    if (look == 0 && contacts.deepest() > now.overlap_before + now.slack + unfelt) overlap = contacts.deepest();
    dvec3 pulled_to = target;
    if (normal_force > 0 && now.may_cut && !now.scrapes) {
      pulled_to = held_target(c0, target, normal, shift, kGripSlew * now.pace_per_slew);
    }
    dvec3 next = nearest_allowed(contacts, c, overlap, now.slack, pulled_to, now.active);
    held_at = next;
    const bool comes_free = now.active.count == 0;
    // A hand that falls is let down as on a floor that sinks.
    const bool falls = now.falls_n != dvec3(0) && glm::dot(next - c0, now.falls_n) < -now.falls &&
                       contacts.add({c, now.falls_n, glm::dot(c - c0, now.falls_n) + now.falls});
    if (falls) next = nearest_allowed(contacts, c, overlap, now.slack, pulled_to, now.active);
    const double pace = (comes_free ? kFreeSlew : kCutSlew) * now.pace_per_slew;
    const double allowed = now.paced ? farthest(next - c0, shift, pace) : 0;
    at_a_pace = falls || (now.paced && glm::length(next - c0 - shift) > kPaceTold * allowed);
    if (at_a_pace && now.may_cut && (falls || !comes_free))
      pulled_to = ease(now, c, c0 + shift, allowed, pulled_to, next);
    // Rough planes chose which hold; exact ones say how far, and others may hold then.
    const int rounds = now.may_cut ? 1 : kRefiningRounds;
    for (int round = 0; round < rounds && contacts.count() > 1 && now.active.count > 0; ++round) {
      bool refined = false;
      for (int i = 0; i < now.active.count; ++i) {
        refined |= head.refine(patch, {c, now.X_WT.R}, contacts, now.active.index[i], !now.may_cut);
      }
      if (!refined) break;
      next = nearest_allowed(contacts, c, overlap, now.slack, pulled_to, now.active);
    }
    // One-sided wall (Wang 2009): coming from softer tissue a bur gets through the boundary of harder only as slowly as
    // if it had the softer's share of its power.
    for (int round = 0; walled && now.slack > 0 && round < kWallRounds && hold_at_walls(now.active, now.slack_at_walls);
         ++round) {
      next = nearest_allowed(contacts, c, overlap, now.slack, pulled_to, now.active);
    }
    now.touching = contacts.count() > 0;
    if (seated) {
      if (contacts.count() > 1 ? nothing_in_the_way(now) : glm::length(next - c) < kSeatedAlone) break;
      c = c0, look = -1, seated = false;
      continue;
    }
    dvec3 step = next - c;
    // Along a smooth curved surface each step is the same share of the one before, of less than nothing in a hollow:
    // all that are still to come at once (the secant method). Two planes of one hollow only hold back.
    if ((contacts.count() == 1 || !now.may_cut) && now.active.count > 0 && !at_a_pace) {
      const double before2 = glm::dot(last_step, last_step);
      const double share = before2 > 0 ? glm::dot(step, last_step) / before2 : 0;
      const double most = now.active.count > 1 ? 1 : contacts.count() > 1 ? kMostGainOfMany : kMostGain;
      last_step = step;
      last_gain = share != 0 && share < kStillConverges ? std::min(last_gain / (1 - share), most) : 1;
      // Toward the tissue each look goes the whole way as it is.
      dvec3 n(0);
      for (int i = 0; i < now.active.count; ++i) n += now.active.push[i] * contacts.plane(now.active.index[i]).n;
      n = glm::normalize(n);
      step += (last_gain - 1) * (step - glm::dot(step, n) * n);
      next = c + step;
    }
    const double length = glm::length(step);
    const double longest = contacts.count() > 1 ? kContactStep : kStep;
    if (length > longest) {
      c += step * (longest / length);
      last_length = 0;
      continue;
    }
    c = next;
    if (at_a_pace) {  // from there on another tick looks
      now.touching = !comes_free;
      break;
    }
    const double settled = contacts.count() > 1 ? now.may_cut ? kSettledCutting : kSettled : kConverged;
    // What is still to come, where each step is at most the share of the one before that this one was.
    const bool foreseen =
        contacts.count() == 1 && length < last_length && length * length < kForeseen * (last_length - length);
    last_length = length;
    if (length < settled || foreseen || ++settled_looks >= (now.may_cut ? kSettlingLooksCutting : kSettlingLooks))
      break;
    // On a smooth surface each look squares the error; when nothing pushes, the target was reached.
    if (now.active.count == 0) {
      now.touching = false;
      break;
    }
  }
  now.c = now.touching ? c0 + share_in_debt(now) * (c - c0) : c;
  if (now.touching) now.held_off = (at_a_pace ? held_at : c) - target + now.c - c;
  wall = walled && now.touching ? wall_of(now.active) : 0;
}

void Servo::State::follow(Touch& now) noexcept {
  // A bur that comes free, over the rim of its own cut or through the last of the tissue, follows the hand at a pace,
  // and so does one whose contacts have turned out to lie elsewhere: what the hand feels changes by so much at most,
  // where the proxy can see to that. The proxy only lags behind, so this takes energy, never gives.
  const bool at_a_pace = now.paced && !now.deep;
  breaking_through = at_a_pace && !now.touching;
  if (at_a_pace) {
    const dvec3 step = now.c - now.c0, shift = now.moved / settings.frame.voxel;
    const double pace = (breaking_through ? kFreeSlew : kCutSlew) * now.pace_per_slew;
    now.c = now.c0 + largest_share(step, -shift, farthest(step, shift, pace)) * step;
    now.lost = now.lost && !patch.holds(now.c, reach() + 1);
  }
  // Beyond the patch the plane of the last contact goes on (the intermediate surface of Adachi 1995; Mark 1996) until a
  // patch arrives, without cutting. Of a patch that is late it gives way where the hand pushes harder than the contact
  // did, so it traps no hand, and between one and two times kBridgeReach it yields altogether; a tool that touched
  // nothing follows the hand then.
  lost_for = now.lost ? lost_for + now.dt : 0;
  const bool late = lost_for > kPatchWait && patch.number != 0;
  now.bridging = now.lost && normal_force > 0;
  if (!(now.bridging && late)) bridge_push = 0;
  if (now.bridging) {
    double under = glm::dot(now.c0 - now.target, normal);
    if (late) {
      if (bridge_push == 0) bridge_push = normal_force, bridge_from = now.c0;
      const double way = glm::length(now.c0 - bridge_from) * settings.frame.voxel;
      const double most = std::clamp(2 - way / kBridgeReach, 0.0, 1.0) * (bridge_push + kBridgeYield) *
                          now.pace_per_slew / now.dt;  // voxels
      under = std::min(under, most);
    }
    now.c = under > 0 ? now.target + under * normal : now.target;
  } else if (late) {
    now.c = now.target;
    overlap = 0;
  }
  if (late) unpaid = true;
  if (now.bridging || late) {
    now.touching = breaking_through = false;
    rejoining = kRejoinTime;
    contacts.clear();
    now.active.count = 0;
  }
  if (overlap > 0) now.faults |= bits(Fault::kDeepPenetration);
  if (now.deep) now.faults |= bits(Fault::kDeepPenetration);
  if (now.lost) now.faults |= bits(Fault::kPatchEdge);
  held = now.touching ? held_by(contacts, now.active) : HeldBy{};
  now.p_WG = now.c == now.target ? now.X_WT.p : settings.frame.to_world(now.c);
  // A patch that has long been due: the carver is late. What the patch holds is still true, so the force stays.
  const bool due =
      patch.number == 0 || patch_due_for(patch_center_for(now.p_WG, now.X_WT.p, travel), patch.center_W, travel);
  due_for = due ? due_for + now.dt : 0;
  if (due_for > kStaleTime) now.faults |= bits(Fault::kStalePatch);
}

}  // namespace typodont::haptics

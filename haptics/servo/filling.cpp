// What a filling instrument puts down: a dome that grows on the tissue nearest to its free end, up to the head.
#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "haptics/fill.h"
#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kFillWaits = 0.05;  // s that filling may wait for room
constexpr double kOneSurface = 0.5;  // slope of the field below which a place lies midway between surfaces
constexpr double kFillLook = 0.25;   // voxels between looks for something to fill on
constexpr double kFillStep = 0.25;   // voxels that a dome may grow in a tick, whatever of its surface is free, …
constexpr double kMostFillStep = 1;  // … and a small one, …
constexpr double kFillAhead = 0.01;  // … by what comes in so many s
constexpr double kLeastFillStep = 1e-3;
constexpr double kBuried = 0.01;   // share of its surface, of which a dome must have more free to go on
constexpr double kOpen = 0.5;      // voxels of air, beyond what the instrument keeps free, that are room
constexpr double kFlowsOn = 3;     // reaches from where it was begun that filling gets through filling
constexpr double kFlowStep = 0.5;  // voxels between looks along its ways
constexpr int kThin = 3;  // looks into tissue that do not part two places: where filling meets a wall they share voxels
constexpr int kLookingOn = 60000;  // ns, about, that a tick may look for room; …
constexpr int kWayLeft = 1, kWayLook = 5,
              kRoomLook = 60;  // … a way that is not looked at, one that is, what the instrument keeps free

/// The radius of a ball that is larger by so much.
double grown(double radius, double volume) {
  return std::cbrt(radius * radius * radius + volume * (3 / (4 * kPi)));
}

}  // namespace

bool Servo::State::fill(Touch& now) noexcept {
  if (!(now.out.pedal > kPedalUp)) {
    filling = {};
    return false;
  }
  filling.owed += tool().fill_rate * now.out.pedal * now.dt;
  const bool changed = !now.lost && !now.deep && filling.owed > 0 && put_down(now);
  if (const double most = tool().fill_rate * kFillWaits; filling.owed > most) {
    filling.owed = most;
    now.faults |= bits(Fault::kNoRoom);
  }
  return changed;
}

/// What is owed, about one centre: true and a Cut when any of it came.
bool Servo::State::put_down(Touch& now) noexcept {
  const Tool& instrument = tool();
  const double h = settings.frame.voxel, voxel = h * h * h, reach = instrument.fill_reach / h;
  const Pose X_WH{now.p_WG, now.X_WT.R};
  if (!begin_dome(X_WH, reach)) return false;
  const auto ball = [&] {
    return Fill(instrument, settings.frame.to_world(filling.center), filling.radius * h, X_WH, settings.frame);
  };
  const bool has_room = filling.radius < reach && patch.holds(filling.center, filling.radius + kMostFillStep +
                                                                                  static_cast<double>(Sweep::kMargin));
  if ((filling.idle || !has_room) && !flow_on(ball(), reach)) return false;

  // So much larger that the part of the dome's surface which is free makes up the volume that is owed: how much head
  // and tissue hide is known from the last tick, and may be less by now.
  const double before = filling.radius, owed = filling.owed / voxel;
  const double most =
      std::clamp(grown(before, owed + instrument.fill_rate * kFillAhead / voxel) - before, kFillStep, kMostFillStep);
  filling.radius += std::clamp(grown(before, owed / filling.share) - before, kLeastFillStep, most);
  const Fill dome = ball();
  bool changed;
  const PerTissue added = haptics::fill(patch, dome, &changed);
  double volume = 0;
  for (const double v : added) volume += v;
  filling.owed -= volume * voxel;
  filling.share =
      std::clamp(volume / (4 * kPi / 3 * (std::pow(filling.radius, 3) - std::pow(before, 3))), kBuried, 1.0);
  filling.idle = !(filling.share > kBuried);
  if (!changed) return false;
  front.forget();
  ++sums.cuts;
  cut_tool = in_hand;
  CutLog::Made made{{settings.frame.to_world(filling.center), X_WH.R}, X_WH, in_hand, false, filling.radius * h, added};
  for (double& v : made.removed) v = -v;
  log.add(sums.cuts, dome.lo(), dome.hi(), made);
  now.cut = {sums.cuts, now.out.index, now.out.t, made.X_WA, X_WH, in_hand, {}, {}, 0, made.fill_radius};
  for (std::size_t i = 1; i < added.size(); ++i) {
    now.cut.removed[i] = -added[i] * voxel;
    sums.removed[i] += now.cut.removed[i];
  }
  return true;
}

/// A dome in which nothing more finds room grows at once as far as the nearest open place that can be seen from where
/// it was begun, through filling, or, where that is out of its reach, goes on with another there. Looks on in the next
/// tick where it has looked enough in this one. False when no such place is found.
bool Servo::State::flow_on(const Fill& instrument, double reach) noexcept {
  const double farthest = kFlowsOn * reach;
  for (int left = kLookingOn; left > 0; left -= kWayLeft, ++outlook.way) {
    if (outlook.way == outlook.ways.size()) outlook.way = 0, ++outlook.looks;
    const double away = outlook.looks * kFlowStep;
    if (!(away < farthest)) return false;
    Outlook::Way& way = outlook.ways[outlook.way];
    if (way.next > outlook.looks) continue;
    left -= kWayLook;
    const dvec3 place = glm::round(filling.root + away * dvec3(flow_ways[outlook.way]));
    if (!patch.holds(place, kMostFillStep + static_cast<double>(Sweep::kMargin))) {
      way.next = Outlook::kNever;
      continue;
    }
    const glm::ivec3 at = glm::ivec3(place) - patch.lo;
    const std::size_t i = patch.at(at.x, at.y, at.z);
    way.in_tissue = patch.distance[i] <= 0 && !is_filled(patch.tissue[i]) ? way.in_tissue + 1 : 0;
    if (way.in_tissue > kThin) way.next = Outlook::kNever;
    if (patch.distance[i] < kOpen) continue;
    left -= kRoomLook;
    const double by_head = instrument.kept_by_head(place);
    if (by_head > -kOpen) {  // and so is as much of the way beyond
      way.next = outlook.looks + 1 + static_cast<int>(std::max(by_head, 0.0) / kFlowStep);
      continue;
    }
    if (instrument.is_limited() && instrument.beyond_limit(place) > -kOpen) continue;
    // There may be more room here: the next look is the same.
    const double off = glm::length(place - filling.center);
    const bool grows = filling.center == filling.root && off < reach && off > filling.radius;
    filling.radius = grows ? off : 0;
    if (!grows) filling.center = place;
    filling.share = 1;
    return true;
  }
  return false;
}

/// A new dome where there is none, or the instrument has moved on.
/// False when nothing is in reach to put it on.
bool Servo::State::begin_dome(const Pose& X_WH, double reach) noexcept {
  const Tool& instrument = tool();
  const double half = instrument.shape == HeadShape::kSphere ? instrument.radius() : instrument.length / 2;
  const dvec3 end = settings.frame.to_voxels(X_WH * dvec3(0, 0, -half));
  const double travelled = glm::length(end - filling.end);
  if (filling.radius >= 0 && travelled <= std::max(0.5 * filling.radius, 1.0)) return true;
  filling.radius = -1;
  if (!patch.holds(end, reach + static_cast<double>(Sweep::kMargin))) return false;
  const FieldSample at = sample_linear_gradient(patch, end);
  const double slope = glm::length(at.gradient);
  if (at.value > reach) return false;
  dvec3 center = end;
  if (at.value > 0 && slope >= kOneSurface) {
    center -= at.value / slope * at.gradient / slope;
  } else if (at.value > 0) {  // midway between walls: on what lies before the instrument
    const dvec3 ahead = X_WH.R * dvec3(0, 0, -1);
    double way = 0;
    while (way <= reach && sample_linear(patch, end + way * ahead) > 0) way += kFillLook;
    if (way > reach) return false;
    center += way * ahead;
  }
  filling = {filling.owed, 0, 1, center, end, center};
  outlook = {};
  return true;
}

}  // namespace typodont::haptics

// What a filling instrument puts down: a dome that grows on the tissue nearest to its free end, up to the head.
#include <algorithm>
#include <cmath>

#include "haptics/fill.h"
#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kFillWaits = 0.05;   // s that filling may wait for room
constexpr double kOneSurface = 0.5;   // slope of the field below which a place lies midway between surfaces
constexpr double kFillLook = 0.25;    // voxels between looks for something to fill on
constexpr double kFillStep = 0.25;    // voxels that a dome may grow at once
constexpr int kFillTries = 4;         // such steps in one tick
constexpr double kOpen = 0.5;         // voxels of air, beyond what the instrument keeps free, that are room
constexpr int kFillLooks = 20000;     // voxels in one tick, for room to flow on to: tenths of a millisecond
constexpr double kFlowsOn = 3;        // reaches from where it was begun that filling gets through filling
constexpr double kThin = 1.5;         // voxels of tissue that do not part two places: where filling meets a wall they share voxels

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
  const double h = settings.frame.voxel, reach = instrument.fill_reach / h;
  const Pose X_WH{now.p_WG, now.X_WT.R};
  if (!begin_dome(X_WH, reach)) return false;
  const auto ball = [&] { return Fill(instrument, settings.frame.to_world(filling.center), filling.radius * h, X_WH, settings.frame); };
  const auto has_room = [&](double radius) {
    return radius < reach && patch.holds(filling.center, radius + kFillTries * kFillStep + static_cast<double>(Sweep::kMargin));
  };
  if ((filling.idle || !has_room(filling.radius)) && !flow_on(ball(), reach)) return false;

  // So much larger that the dome's surface makes up the volume that is owed; where the head or tissue hides that surface
  // it finds out, and grows faster.
  PerTissue added{};
  bool changed = false;
  glm::ivec3 lo(0), hi(0);
  filling.idle = true;
  for (int tries = 0; tries < kFillTries && filling.owed > 0 && has_room(filling.radius); ++tries) {
    const double step = std::max(std::min(filling.owed / (h * h * h) / filling.area, kFillStep), 1e-3);
    filling.radius += step;
    const Fill grown = ball();
    bool any;
    double volume = 0;
    const PerTissue more = haptics::fill(patch, grown, &any);
    for (std::size_t i = 0; i < more.size(); ++i) volume += more[i], added[i] += more[i];
    changed |= any;
    lo = grown.lo(), hi = grown.hi();
    filling.area = std::max(volume / step, 1.0);
    filling.owed -= volume * h * h * h;
    filling.idle &= !(volume > 0);
  }
  if (!changed) return false;
  const dvec3 center_W = settings.frame.to_world(filling.center);
  front.forget();
  ++sums.cuts;
  cut_tool = in_hand;
  CutLog::Made made{{center_W, X_WH.R}, X_WH, in_hand, false, filling.radius * h, added};
  for (double& v : made.removed) v = -v;
  log.add(sums.cuts, lo, hi, made);
  now.cut = {sums.cuts, now.out.index, now.out.t, made.X_WA, X_WH, in_hand, {}, {}, 0, made.fill_radius};
  for (std::size_t i = 1; i < added.size(); ++i) {
    now.cut.removed[i] = -added[i] * h * h * h;
    sums.removed[i] += now.cut.removed[i];
  }
  return true;
}

/// Whether no tissue but filling lies between two places, voxels.
bool Servo::State::lies_open(const dvec3& from, const dvec3& to) const noexcept {
  const double way = glm::length(to - from);
  double tissue = 0;
  for (double s = 0; s < way; s += 0.5) {
    const dvec3 p = glm::mix(from, to, s / way);
    const dvec3 q = p - dvec3(patch.lo) + 0.5;
    const std::size_t i = patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z));
    tissue = patch.distance[i] <= 0 && !is_filled(patch.tissue[i]) ? tissue + 0.5 : 0;
    if (tissue > kThin) return false;
  }
  return true;
}

/// A dome in which nothing more finds room grows at once as far as an open place near where it was begun, or, where that is
/// out of its reach, goes on with another there. Looks on in the next tick where it has looked enough in this one. False when
/// no such place is found.
bool Servo::State::flow_on(const Fill& instrument, double reach) noexcept {
  if (!patch.holds(filling.root, 1)) return false;
  const glm::ivec3 middle(glm::round(filling.root));
  dvec3 place(0);
  double nearest = kFlowsOn * reach;
  const double none = nearest;
  int left = kFillLooks;
  const auto look_at = [&](const glm::ivec3& v) {
    --left;
    const double away = glm::length(dvec3(v) - filling.root);
    if (away >= nearest || !patch.holds(dvec3(v), kFillTries * kFillStep + static_cast<double>(Sweep::kMargin))) return;
    const glm::ivec3 at = v - patch.lo;
    if (patch.distance[patch.at(at.x, at.y, at.z)] < kOpen || instrument.kept_out(dvec3(v)) > -kOpen) return;
    if (lies_open(filling.root, dvec3(v))) nearest = away, place = dvec3(v);
  };
  for (; nearest == none && left > 0 && filling.shell < none; ++filling.shell) {  // of a cube
    const int s = filling.shell;
    for (int x = -s; x <= s; ++x) {
      for (int y = -s; y <= s; ++y) {
        const int every = std::abs(x) == s || std::abs(y) == s ? 1 : std::max(2 * s, 1);
        for (int z = -s; z <= s; z += every) look_at(middle + glm::ivec3(x, y, z));
      }
    }
  }
  if (nearest == none) return false;
  --filling.shell;  // there may be more of it
  const double away = glm::length(place - filling.center);
  if (filling.center == filling.root && away < reach && away > filling.radius) {
    filling.radius = away;
  } else {
    filling.center = place;
    filling.radius = 0;
  }
  filling.area = 1;
  return true;
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
  return true;
}

}  // namespace typodont::haptics

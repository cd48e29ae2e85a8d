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
constexpr double kFillStep = 0.25;    // voxels a tick that a dome may grow
constexpr int kFillTries = 4;         // steps in one tick, until one finds room

}  // namespace

bool Servo::State::fill(Touch& now) noexcept {
  if (now.lost || now.deep) return false;
  const Tool& instrument = tool();
  const double h = settings.frame.voxel, reach = instrument.fill_reach / h;
  if (!(now.out.pedal > kPedalUp)) {
    filling = {};
    return false;
  }
  filling.owed += instrument.fill_rate * now.out.pedal * now.dt;
  filling.owed = std::min(filling.owed, instrument.fill_rate * kFillWaits);
  const Pose X_WH{now.p_WG, now.X_WT.R};
  if (!(filling.owed > 0) || !begin_dome(X_WH, reach)) return false;

  // So much larger that the dome's surface makes up the volume that is owed; where the head or tissue hides that surface
  // it finds out, and grows faster.
  const dvec3 center_W = settings.frame.to_world(filling.center);
  double volume = 0;
  PerTissue added{};
  bool changed = false;
  glm::ivec3 lo(0), hi(0);
  for (int tries = 0; tries < kFillTries && !(volume > 0); ++tries) {
    const double step =
        std::max(std::min({filling.owed / (h * h * h) / filling.area, kFillStep, reach - filling.radius}), 1e-3);
    filling.radius += step;
    const Fill ball(instrument, center_W, filling.radius * h, X_WH, settings.frame);
    bool any;
    added = haptics::fill(patch, ball, &any);
    changed |= any;
    lo = ball.lo(), hi = ball.hi();
    for (const double v : added) volume += v;
    filling.area = std::max(volume / step, 1.0);
  }
  filling.owed -= volume * h * h * h;
  if (!changed) return false;
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

/// A new dome where there is none, the old one is as large as the instrument makes them, or the instrument has moved on.
/// False when nothing is in reach to put it on.
bool Servo::State::begin_dome(const Pose& X_WH, double reach) noexcept {
  const Tool& instrument = tool();
  const double half = instrument.shape == HeadShape::kSphere ? instrument.radius() : instrument.length / 2;
  const dvec3 end = settings.frame.to_voxels(X_WH * dvec3(0, 0, -half));
  const double travelled = glm::length(end - filling.end);
  if (filling.radius >= 0 && filling.radius < reach && travelled <= std::max(0.5 * filling.radius, 1.0)) return true;
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
  filling.center = center;
  filling.end = end;
  filling.radius = 0;
  filling.area = 1;
  return true;
}

}  // namespace typodont::haptics

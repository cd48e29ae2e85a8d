// Adds filling: a ball grows around the tissue point nearest to the instrument's free end, but not into the head.
#include <algorithm>
#include <cmath>

#include "haptics/contact/offset/offset_model.h"
#include "haptics/cutting/carve.h"
#include "haptics/fill.h"
#include "haptics/sweep.h"

namespace typodont::haptics::offset {

namespace {

using P = FillingParameters;

/// Radius of a ball whose volume is larger by `volume` than that of a ball with `radius`.
double grown(double radius, double volume) {
  return std::cbrt(radius * radius * radius + volume * (3 / (4 * kPi)));
}

}  // namespace

bool OffsetModel::fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept {
  if (!(in.removal.pedal > kPedalUp)) {
    filling_ = {};
    return false;
  }
  filling_.owed += tool().fill_rate * in.removal.pedal * in.dt;
  const bool changed = !step_.gap.lost && !step_.deep && filling_.owed > 0 && place_filling(in, contact, cut);
  if (const double most = tool().fill_rate * P::waits; filling_.owed > most) {
    filling_.owed = most;
    contact.faults |= bits(Fault::kNoRoom);
  }
  return changed;
}

/// Adds the filling that the instrument delivered but did not place yet. If any was added, returns true, sets `cut`.
bool OffsetModel::place_filling(const ContactInput& in, const Contact& contact, Cut& cut) noexcept {
  const Tool& instrument = tool();
  const double h = settings_.frame.voxel, voxel = h * h * h, reach = instrument.fill_reach / h;
  const Pose X_WH{contact.p_WG, in.X_WT.R};
  if (!begin_ball(X_WH, reach)) return false;
  const auto ball = [&] {
    return Fill(instrument, settings_.frame.to_world(filling_.center), filling_.radius * h, X_WH, settings_.frame);
  };
  const bool has_room =
      filling_.radius < reach &&
      patch_.holds(filling_.center, filling_.radius + P::max_step + static_cast<double>(Sweep::kMargin));
  if ((filling_.idle || !has_room) && !search_open_place(ball(), reach)) return false;

  // Only the part of the ball's surface in air can grow. The fraction of this part is taken from the last tick, so the
  // added volume may differ from the delivered volume.
  const double before = filling_.radius, owed = filling_.owed / voxel;
  const double most =
      std::clamp(grown(before, owed + instrument.fill_rate * P::ahead / voxel) - before, P::step, P::max_step);
  filling_.radius += std::clamp(grown(before, owed / filling_.free_fraction) - before, P::min_step, most);
  const Fill dome = ball();
  bool changed;
  const PerTissue added = haptics::fill(patch_, dome, &changed);
  double volume = 0;
  for (const double v : added) volume += v;
  filling_.owed -= volume * voxel;
  filling_.free_fraction =
      std::clamp(volume / (4 * kPi / 3 * (std::pow(filling_.radius, 3) - std::pow(before, 3))), P::buried, 1.0);
  filling_.idle = !(filling_.free_fraction > P::buried);
  if (!changed) return false;
  contacts_.forget_creases();
  front_.forget();
  cut_tool_ = tool_;
  CutLog::Made made{
      {settings_.frame.to_world(filling_.center), X_WH.R}, X_WH, tool_, false, filling_.radius * h, added};
  for (double& v : made.removed) v = -v;
  log_.add(++cut_count_, dome.lo(), dome.hi(), made);
  cut.X_WA = made.X_WA, cut.X_WB = X_WH;
  cut.fill_radius = made.fill_radius;
  cut.spindle = 0;
  for (std::size_t i = 1; i < added.size(); ++i) cut.removed[i] = -added[i] * voxel;
  return true;
}

/// If the ball of filling cannot grow: searches the nearest place with room, along rays from the first ball through
/// filled voxels. The ball is enlarged up to this place, or a new ball begins there. If the search takes longer than
/// search_cost, the next tick continues it. Returns false if no place was found yet.
bool OffsetModel::search_open_place(const Fill& instrument, double reach) noexcept {
  const double farthest = P::flows_on * reach;
  for (int left = P::search_cost; left > 0; left -= P::skip_cost, ++open_place_search_.current) {
    if (open_place_search_.current == open_place_search_.rays.size())
      open_place_search_.current = 0, ++open_place_search_.sample;
    const double away = open_place_search_.sample * P::flow_step;
    if (!(away < farthest)) return false;
    OpenPlaceSearch::Ray& ray = open_place_search_.rays[open_place_search_.current];
    if (ray.next > open_place_search_.sample) continue;
    left -= P::sample_cost;
    const dvec3 place = glm::round(filling_.root + away * dvec3(flow_directions_[open_place_search_.current]));
    if (!patch_.holds(place, P::max_step + static_cast<double>(Sweep::kMargin))) {
      ray.next = OpenPlaceSearch::kNever;
      continue;
    }
    const glm::ivec3 at = glm::ivec3(place) - patch_.lo;
    const std::size_t i = patch_.at(at.x, at.y, at.z);
    ray.in_tissue = patch_.distance[i] <= 0 && !is_filled(patch_.tissue[i]) ? ray.in_tissue + 1 : 0;
    if (ray.in_tissue > P::thin) ray.next = OpenPlaceSearch::kNever;
    if (patch_.distance[i] < P::open) continue;
    left -= P::room_cost;
    const double by_head = instrument.kept_by_head(place);
    if (by_head > -P::open) {  // the head covers the ray up to this sample
      ray.next = open_place_search_.sample + 1 + static_cast<int>(std::max(by_head, 0.0) / P::flow_step);
      continue;
    }
    if (instrument.is_limited() && instrument.beyond_limit(place) > -P::open) continue;
    // The ray is not advanced: this sample may still have room for filling later, so the next search examines the
    // sample again.
    const double off = glm::length(place - filling_.center);
    const bool grows = filling_.center == filling_.root && off < reach && off > filling_.radius;
    filling_.radius = grows ? off : 0;
    if (!grows) filling_.center = place;
    filling_.free_fraction = 1;
    return true;
  }
  return false;
}

/// Begins a new ball of filling if there is none, or if the instrument has moved. Returns false if no tissue is within
/// `reach` of the instrument.
bool OffsetModel::begin_ball(const Pose& X_WH, double reach) noexcept {
  const Tool& instrument = tool();
  const double half = instrument.shape == HeadShape::kSphere ? instrument.radius() : instrument.length / 2;
  const dvec3 end = settings_.frame.to_voxels(X_WH * dvec3(0, 0, -half));
  const double travelled = glm::length(end - filling_.end);
  if (filling_.radius >= 0 && travelled <= std::max(0.5 * filling_.radius, 1.0)) return true;
  filling_.radius = -1;
  if (!patch_.holds(end, reach + static_cast<double>(Sweep::kMargin))) return false;
  const FieldSample at = sample_linear_gradient(patch_, end);
  const double slope = glm::length(at.gradient);
  if (at.value > reach) return false;
  dvec3 center = end;
  if (at.value > 0 && slope >= P::one_surface) {
    center -= at.value / slope * at.gradient / slope;
    // Midway between two walls, the ball of filling begins on the tissue in front of the instrument.
  } else if (at.value > 0) {
    const dvec3 ahead = X_WH.R * dvec3(0, 0, -1);
    double travel = 0;
    while (travel <= reach && sample_linear(patch_, end + travel * ahead) > 0) travel += P::search_step;
    if (travel > reach) return false;
    center += travel * ahead;
  }
  filling_ = {filling_.owed, 0, 1, center, end, center};
  open_place_search_ = {};
  return true;
}

}  // namespace typodont::haptics::offset

#include "engine/session/implant.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engine/base/nearest.h"
#include "engine/base/units.h"

namespace typodont::session {

namespace {

constexpr std::array<std::string_view, kImplantNoteCount> kNotes = {
    "none", "wrong_tool", "over_speed", "too_deep", "off_axis", "near_canal", "heat", "over_force"};
// If the spindle is faster than the phase's speed by this factor, a warning is shown.
constexpr double kOverSpeed = 1.1;
// s; when the trainee has worked for this time with the tool of a later phase, that phase begins.
constexpr double kSkipPhaseTime = 1.5;
// s; the goal of smoothing, marking or checking must hold for this time.
constexpr double kHeld = 0.3;
// m; the hole counts as drilled if the tip is less than this above the required depth.
constexpr double kDrilled = 0.05e-3;
// m; the hole counts as checked if the depth gauge is less than this above the required depth.
constexpr double kChecked = 0.25e-3;
// m; the thread counts as cut if the tap is less than this above the required depth.
constexpr double kThreaded = 0.3e-3;
// N; below this force there is no contact: the tool follows the hand.
constexpr double kMinContactForce = 0.05;
// m; an implant or screw counts as placed if it protrudes by less than this.
constexpr double kMaxProtrusion = 1e-3;
// m/s along the axis; a faster tool counts as moving deeper.
constexpr double kInsertionSpeed = 0.1e-3;
constexpr double kInsertionFilterTime = 0.1;  // s, time constant of the axial speed's low-pass filter
// m; a tip closer to the planned axis than this is at the right site.
constexpr double kAtSite = 3e-3;
// m below the planned entry; the tool's angle is checked only from this depth on.
constexpr double kOffAxisFrom = 1e-3;

double volume_of(const ServoTick& tick) {
  return total(tick.removed);
}

}  // namespace

double ImplantCylinder::distance(const dvec3& p_W) const {
  const dvec3 from = p_W - bottom_W;
  const double along = glm::dot(from, axis_W);
  const double aside = glm::length(from - along * axis_W) - radius, beyond = std::max(along, -along - length);
  return std::min(std::max(aside, beyond), 0.0) + std::hypot(std::max(aside, 0.0), std::max(beyond, 0.0));
}

double ImplantCylinder::distance(std::span<const dvec3> path_W) const {
  // Distance between sampled points of the path, m.
  constexpr double kStep = 0.05e-3;
  double best = 1e9;
  for (std::size_t i = 0; i + 1 < path_W.size(); ++i) {
    const dvec3 segment = path_W[i + 1] - path_W[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(segment) / kStep)));
    for (int k = 0; k <= steps; ++k)
      best = std::min(best, distance(path_W[i] + (static_cast<double>(k) / steps) * segment));
  }
  return best;
}

std::string_view name_of(ImplantNote note) noexcept {
  return kNotes[static_cast<std::size_t>(note)];
}

double ImplantMeasures::phases_done() const {
  if (phases.empty()) return 0;
  const auto done = std::count_if(phases.begin(), phases.end(), [](const auto& p) { return p.done; });
  return static_cast<double>(done) / static_cast<double>(phases.size());
}

ImplantMeter::ImplantMeter(ImplantTask task) : task_(std::move(task)) {
  measures_.phases.resize(task_.phases.size());
  for (std::size_t i = 0; i < task_.phases.size(); ++i) {
    measures_.phases[i].name = task_.phases[i].name.text;
    measures_.phases[i].force.along.reserve(2 * kBins);
    measures_.phases[i].force.across.reserve(2 * kBins);
  }
  along_.reserve(2 * kBins);
  across_.reserve(2 * kBins);
}

void ImplantMeter::add(std::span<const ServoTick> ticks) {
  for (const ServoTick& tick : ticks) {
    const double dt = started_ ? std::clamp(to_seconds(tick.t - last_t_), 0.0, 0.1) : 0;
    if (!started_) removed_last_ = volume_of(tick);
    started_ = true;
    last_t_ = tick.t;
    if (is_finite(tick.X_WG.p)) follow(tick, dt);
  }
}

void ImplantMeter::heat(const ServoTick& tick, double dt, bool irrigated) {
  // The heated bone is a shell around the drilled hole. Its depth is the hole's, but at least the hole's diameter.
  const double r = task_.radius[tick.tool], deep = std::max(depth_, 2 * r), s = HeatModel::shell;
  // Heat capacity of the heated bone, J/K.
  const double warmed = kPi * ((r + s) * (r + s) - r * r) * deep * HeatModel::heat_capacity;
  const double time = irrigated ? HeatModel::cooled_time : HeatModel::dry_time;
  temperature_ += dt * HeatModel::fraction * tick.cutting_power / warmed;
  temperature_ = HeatModel::body + (temperature_ - HeatModel::body) * std::exp(-dt / time);
  measures_.hottest = std::max(measures_.hottest, temperature_);
}

ImplantNote ImplantMeter::note_of(const ServoTick& tick, const dvec3& tip_W, const dvec3& axis_W, bool touches) const {
  const bool turns = std::abs(tick.spindle) > 0.1;
  if (phase_ < task_.phases.size() && tick.tool != task_.phases[phase_].tool && works_) return ImplantNote::kWrongTool;
  const ImplantPhase* phase = phase_ < task_.phases.size() ? &task_.phases[phase_] : nullptr;
  if (phase && phase->tool == tick.tool) {
    if (phase->speed > 0 && tick.spindle > kOverSpeed * phase->speed) return ImplantNote::kOverSpeed;
    const bool deepens = phase->deed == ImplantAction::kDrill || phase->deed == ImplantAction::kTap;
    if (touches && turns && deepens && depth_ > phase->depth + task_.depth_tolerance) return ImplantNote::kTooDeep;
    if (depth_ > kOffAxisFrom && phase->deed != ImplantAction::kSmooth &&
        std::acos(std::clamp(glm::dot(axis_W, task_.plan.axis_W), -1.0, 1.0)) > task_.max_angle)
      return ImplantNote::kOffAxis;
  }
  if (!task_.canal_W.empty() && touches && turns &&
      distance_to_path(task_.canal_W, tip_W) - task_.canal_radius < task_.canal_clearance)
    return ImplantNote::kNearCanal;
  if (temperature_ > HeatModel::harmful) return ImplantNote::kHeat;
  if (touches && glm::length(tick.f_T_W) > task_.max_force) return ImplantNote::kOverForce;
  return ImplantNote::kNone;
}

bool ImplantMeter::is_done(const ImplantPhase& phase, const ServoTick& tick, bool touches, double dt) {
  bool met = false;
  double needed = 0;
  switch (phase.deed) {
    case ImplantAction::kSmooth:
    case ImplantAction::kMark:
      // The phase is done when enough is removed and the bur no longer touches.
      met = removed_in_phase_ >= phase.volume && !touches;
      needed = kHeld;
      break;
    case ImplantAction::kDrill:
      met = depth_ >= phase.depth - kDrilled;
      break;
    case ImplantAction::kCheck:
      met = tick.level != implant_level::kFree && depth_ >= phase.depth - kChecked;
      needed = kHeld;
      break;
    case ImplantAction::kTap:
      met = tick.level == implant_level::kScrewing && depth_ >= phase.depth - kThreaded;
      break;
    case ImplantAction::kPlace:
    case ImplantAction::kClose:
      met = tick.level == implant_level::kPlaced && measures_.phases[phase_].depth >= phase.depth - kMaxProtrusion;
      break;
  }
  held_ = met ? held_ + dt : 0;
  return met && held_ >= needed;
}

void ImplantMeter::record(const ServoTick& tick, double dt) {
  const double along = glm::dot(tick.f_T_W, task_.plan.axis_W);
  across_sum_ += dt * glm::length(tick.f_T_W - along * task_.plan.axis_W);
  along_sum_ += dt * along;
  span_filled_ += dt;
  if (span_filled_ < span_) return;
  across_.push_back(across_sum_ / span_filled_);
  along_.push_back(along_sum_ / span_filled_);
  across_sum_ = along_sum_ = span_filled_ = 0;
  if (across_.size() < 2 * kBins) return;
  for (std::vector<double>* curve : {&across_, &along_}) {
    for (std::size_t i = 0; i < kBins; ++i) (*curve)[i] = 0.5 * ((*curve)[2 * i] + (*curve)[2 * i + 1]);
    curve->resize(kBins);
  }
  span_ *= 2;
}

void ImplantMeter::finish_phase(const ServoTick& tick) {
  ImplantPhaseMeasures& m = measures_.phases[phase_];
  if (m.began >= 0) m.ended = to_seconds(tick.t);
  m.force.span = span_;
  m.force.across.assign(across_.begin(), across_.end());
  m.force.along.assign(along_.begin(), along_.end());
  across_.clear(), along_.clear();
  span_ = 0.01, span_filled_ = across_sum_ = along_sum_ = 0;
  removed_in_phase_ = held_ = later_tool_time_ = 0;
  ++phase_;
}

void ImplantMeter::follow(const ServoTick& tick, double dt) {
  if (tick.tool >= task_.tip.size()) return;
  const ImplantPlan& plan = task_.plan;
  const dvec3 axis_W = tick.X_WG.R * dvec3(0, 0, -1), tip_W = tick.X_WG.p + task_.tip[tick.tool] * axis_W;
  depth_ = glm::dot(tip_W - plan.entry_W, plan.axis_W);
  const double force = glm::length(tick.f_T_W);
  const bool touches = tick.contact_area > 0 || force > kMinContactForce;
  const double removed = volume_of(tick), cut = std::max(0.0, removed - removed_last_);
  removed_last_ = removed;
  // Only cutting and moving deeper count as work, so that pulling out the previous phase's tool causes no warning.
  if (dt > 0)
    insertion_speed_ += ((depth_ - last_depth_) / dt - insertion_speed_) * (1 - std::exp(-dt / kInsertionFilterTime));
  last_depth_ = depth_;
  works_ = touches && (tick.cutting_power > 0 || insertion_speed_ > kInsertionSpeed);
  // The trainee may still smooth or mark with the bur of the previous phase.
  const ImplantPhase* before = phase_ > 0 ? &task_.phases[phase_ - 1] : nullptr;
  if (before && before->tool == tick.tool &&
      (before->deed == ImplantAction::kSmooth || before->deed == ImplantAction::kMark))
    works_ = false;
  // If the trainee works with a later phase's tool for kSkipPhaseTime, the phases before that phase are skipped.
  if (phase_ < task_.phases.size() && tick.tool == task_.phases[phase_].tool) later_tool_time_ = 0;
  if (phase_ < task_.phases.size() && tick.tool != task_.phases[phase_].tool && works_) {
    const auto later = std::find_if(task_.phases.begin() + static_cast<std::ptrdiff_t>(phase_), task_.phases.end(),
                                    [&](const ImplantPhase& p) { return p.tool == tick.tool; });
    later_tool_time_ = later == task_.phases.end() ? 0 : later_tool_time_ + dt;
    if (later_tool_time_ > kSkipPhaseTime) {
      const auto to = static_cast<std::size_t>(later - task_.phases.begin());
      while (phase_ < to) {
        measures_.phases[phase_].skipped = true;
        finish_phase(tick);
      }
    }
  }
  const ImplantPhase* phase = phase_ < task_.phases.size() ? &task_.phases[phase_] : nullptr;
  heat(tick, dt, phase && phase->irrigated);
  note_ = note_of(tick, tip_W, axis_W, touches);
  if (touches && force > task_.max_force) measures_.over_force += dt;

  // The drilled hole's geometry follows from the drill's positions in it.
  if (tick.level == implant_level::kDrilling || tick.level == implant_level::kPerforating) {
    axis_sum_ += axis_W * dt;
    if (depth_ < top_) top_ = depth_, top_W_ = tip_W;
    if (depth_ > bottom_) bottom_ = depth_, bottom_W_ = tip_W;
    bed_radius_ = std::max(bed_radius_, task_.radius[tick.tool]);
  }
  if (!phase) return;
  ImplantPhaseMeasures& m = measures_.phases[phase_];
  m.noted[static_cast<std::size_t>(note_)] += dt;
  if (tick.tool != phase->tool) return;
  removed_in_phase_ += glm::length(tip_W - plan.entry_W - glm::dot(tip_W - plan.entry_W, plan.axis_W) * plan.axis_W) <
                               (phase->deed == ImplantAction::kMark ? kAtSite : 1e9)
                           ? cut
                           : 0.0;
  if (touches) {
    if (m.began < 0) m.began = to_seconds(tick.t);
    m.force_max = std::max(m.force_max, force);
    if (force > task_.max_force) m.over_force += dt;
    if (tick.level != implant_level::kFree && tick.level != implant_level::kPlaced) m.depth = std::max(m.depth, depth_);
    m.hottest = std::max(m.hottest, temperature_);
    record(tick, dt);
  }
  if (phase->deed == ImplantAction::kPlace && tick.level == implant_level::kScrewing)
    measures_.insertion_torque = std::max(measures_.insertion_torque, std::abs(glm::dot(tick.tau_T_W, plan.axis_W)));
  if (phase->deed == ImplantAction::kPlace && tick.level == implant_level::kPlaced) measures_.placed = true;
  if (!is_done(*phase, tick, touches, dt)) return;
  m.done = true;
  finish_phase(tick);
}

ImplantMeasures ImplantMeter::result() const {
  ImplantMeasures out = measures_;
  // Completes the force curve of the current, unfinished phase.
  if (phase_ < out.phases.size()) {
    ForceCurve& curve = out.phases[phase_].force;
    curve.span = span_;
    curve.across.assign(across_.begin(), across_.end());
    curve.along.assign(along_.begin(), along_.end());
  }
  ImplantBedMeasures& bed = out.bed;
  bed.found = glm::length(axis_sum_) > 0 && bottom_ > 1e-3;
  if (!bed.found) return out;
  const ImplantPlan& plan = task_.plan;
  const dvec3 axis = glm::normalize(axis_sum_);
  bed.axis_error = std::acos(std::clamp(glm::dot(axis, plan.axis_W), -1.0, 1.0));
  bed.depth = bottom_;
  // Distance from the drilled hole's bottom, along its axis, to the plane of the implant's platform.
  const double to_platform =
      glm::dot(bottom_W_ - plan.entry_W, plan.axis_W) / std::max(0.1, glm::dot(axis, plan.axis_W));
  bed.entry_error = glm::length(bottom_W_ - to_platform * axis - plan.entry_W);
  bed.apex_error = glm::length(bottom_W_ - plan.apex_W());
  // Distance between the drilled hole and a path; 0 if the path goes through the hole.
  const ImplantCylinder shape{bottom_W_, axis, to_platform, bed_radius_};
  const auto outside = [&](std::span<const dvec3> path_W) { return std::max(0.0, shape.distance(path_W)); };
  if (!task_.canal_W.empty()) bed.canal_distance = outside(task_.canal_W) - task_.canal_radius;
  for (const NeighbourRoot& root : task_.neighbours)
    bed.neighbour_distance = std::min(bed.neighbour_distance, outside(std::array{root.a_W, root.b_W}) - root.radius);
  return out;
}

}  // namespace typodont::session

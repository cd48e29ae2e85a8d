// A session in which the simulated hand of an expert works in a shipped scene, in simulated time.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/hands/expert_hand.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/stepped.h"
#include "engine/app/task/damage.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/task.h"

namespace typodont::test {

/// Contacts of a running drill, and the hand's tremor.
class DrillMeter {
 public:
  void add(const ServoTick& tick) {
    constexpr double kContact = 0.1, kGap = 0.2, kEnd = 0.7;  // N, the least that was measured; s; cosine to the axis
    const double t = to_seconds(tick.t), force = glm::length(tick.f_T_W);
    for (std::size_t i = 0; i < kTremor.size(); ++i)
      moved_[i] += std::polar(1.0, -2 * kPi * kTremor[i] * t) * tick.X_WT.p.x;
    ++ticks_;
    if (tick.pedal < 0.5 || force < kContact) return;
    if (begins_.empty() || t - last_ > kGap) {
      if (!begins_.empty()) lasts_.push_back(last_ - begins_.back());
      begins_.push_back(t);
    }
    last_ = t;
    const bool end = std::abs(glm::dot(tick.n_C_W, tick.X_WG.R * dvec3(0, 0, 1))) > kEnd;
    force_[end] += force;
    touched_[end] += 1;
  }
  double force() const { return (force_[0] + force_[1]) / (touched_[0] + touched_[1]); }  // N, mean
  double side_force() const { return force_[0] / touched_[0]; }
  double end_force() const { return force_[1] / touched_[1]; }
  double contact() const { return median(lasts_); }  // s
  double contacts_per_second() const {
    std::vector<double> periods;
    for (std::size_t i = 1; i < begins_.size(); ++i) periods.push_back(begins_[i] - begins_[i - 1]);
    return 1 / median(periods);
  }
  /// Amplitude along x at 8.1 Hz, m, and how many times it exceeds that of neighbouring frequencies.
  double tremor() const { return 2 * std::abs(moved_[1]) / ticks_; }
  double tremor_peak() const { return std::abs(moved_[1]) / std::max(std::abs(moved_[0]), std::abs(moved_[2])); }

 private:
  static constexpr std::array kTremor{7.6, 8.1, 8.6};  // Hz
  static double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }
  std::array<std::complex<double>, 3> moved_{};
  std::vector<double> begins_, lasts_;         // s, of contacts
  std::array<double, 2> force_{}, touched_{};  // N, ticks: of side, end
  double last_ = 0, ticks_ = 0;
};

struct ExpertResult {
  double percent = 0, seconds = 0;
  DrillMeter drill;
  double decay_seen = 0;  // fraction of the cut surface that shows caries
  std::string items;      // the score's items, one per line
  double tremor = 0;      // m rms, as scored
};

/// Returns the fraction of the samples next to new surface that are labelled as caries.
inline double decay_on_new_surface(const haptics::TissueVolume& before, const haptics::TissueVolume& after) {
  const DenseCopy now = dense_copy(after);
  const DenseCopy then =
      dense_copy(before, glm::ivec3(glm::round(before.frame().to_voxels(now.frame.origin))), now.field.size);
  double fresh = 0, decay = 0;
  for (std::size_t i = 0; i < now.tissue.size(); ++i) {
    if (now.field.distance[i] > 0 || now.field.distance[i] < -1 || then.field.distance[i] > -1.5f) continue;
    ++fresh;
    decay += now.tissue[i] == Tissue::kCaries;
  }
  return fresh > 0 ? decay / fresh : 0;
}

/// Runs the expert's hand with servo and carver, tick by tick, and scores the result like any session. Throws
/// RunFailure if the session lasts longer than `longest` seconds.
inline ExpertResult expert_session(const std::string& name, double longest) {
  const Scene scene = read_scene(assets_folder() / "scenes" / (name + ".json"));
  const haptics::TissueVolume start = load_untouched(scene);
  const TaskEvaluator judge(scene, start);
  SteppedSession session(scene, load_tissue(scene), 1000);
  session::HandMeter meter(1000);
  DrillMeter drill;
  std::optional<DamageMeter> damage = damage_meter(scene);
  std::optional<HeatMeter> heat = heat_meter(scene, start);
  std::optional<session::ImplantMeter> surgery;
  std::unique_ptr<haptics::HapticDevice> hand;
  if (scene.implant) {
    surgery.emplace(*scene.implant);
    hand = std::make_unique<ImplantExpert>(scene, 1000);
  } else {
    hand = std::make_unique<PlanningExpert>(scene, session.carver(), 1000);
  }
  while (session.advance(*hand)) {
    const ServoTick& tick = session.last();
    if (to_seconds(tick.t) > longest) throw RunFailure(name + ": the expert does not end");
    meter.add({&tick, 1});
    drill.add(tick);
    if (damage) damage->add({&tick, 1});
    if (heat) heat->add({&tick, 1}, scene.spray_on);
    if (surgery) surgery->add({&tick, 1});
  }
  session::ScoreInput input;
  input.before = start.volumes();
  input.after = session.carver().volume().volumes();
  input.hand = meter.result();
  if (damage) input.damage = damage->result();
  if (heat) input.heat = heat->result();
  if (surgery) {
    input.implant = surgery->result();
    measure_bed(*scene.implant, session.carver().volume(), *input.implant);
  }
  judge.judge(session.carver().volume(), input);
  const session::Score score = session::score(input, session::rules_of_scene(Json::parse(scene.text, "scene"), input));
  ExpertResult result{100 * score.points / score.full, input.hand.time, drill,
                      decay_on_new_surface(start, session.carver().volume()), ""};
  result.tremor = input.hand.tremor_rms;
  for (const session::ScoreItem& item : score.items) {
    if (item.weight > 0)
      result.items += fmt::format("{} = {:.3f} {} (target {:.3f}): {:.1f} of {:.0f}\n", item.name, item.value,
                                  item.unit, item.target, item.points, item.weight);
  }
  fmt::print(
      "{} by an expert's hand: {:.1f} % in {:.0f} s; {:.2f} N (side {:.2f}, end {:.2f}), {:.2f} contacts a second of "
      "{:.2f} s, tremor {:.0f} µm, {:.1f} times its neighbours\n",
      name, result.percent, result.seconds, drill.force(), drill.side_force(), drill.end_force(),
      drill.contacts_per_second(), drill.contact(), drill.tremor() * 1e6, drill.tremor_peak());
  return result;
}

}  // namespace typodont::test

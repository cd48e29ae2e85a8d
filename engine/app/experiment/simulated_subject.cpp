#include "engine/app/experiment/simulated_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engine/app/session_start.h"
#include "engine/app/wiring.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

// The tool is in contact if the force exceeds this fraction of the stimulus's largest force.
constexpr double kTouched = 0.1;
constexpr double kDelayRange = 1;          // s, largest delay of the force
constexpr Nanos kPause = kNanosPerSecond;  // ns, pause in the air between two stimuli

/// Uniform random number in [0, 1), equal in every library.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

bool inside(const ServoTick& tick) {
  return tick.depth > 0 || (tick.faults & bits(Fault::kDeepPenetration)) != 0;
}

double relative(double greater, double lesser) {
  return 100 * (greater / lesser - 1);
}
/// second − first, in % of the nominally smaller stimulus.
double signed_percent(const Trial& trial, double first, double second) {
  return trial.greater_second ? relative(second, first) : -relative(first, second);
}

}  // namespace

Answer SimulatedObserver::judge(double difference) {
  // The probability truth_.second() already includes lapses and bias.
  return uniform(random_) < truth_.second(difference) ? Answer::kSecond : Answer::kFirst;
}

double nominal_difference(const Trial& trial) {
  return trial.greater_second ? trial.level : -trial.level;
}

struct ScriptedTouch::Loop {
  Scene scene;
  SteppedSession session;
  haptics::ForceDelay delay;
  Nanos ended = 0;  // ns, time at which the previous stimulus ended

  Loop(const Scene& s, const haptics::DeviceInfo& hand)
      : scene(s), session(start_session(s, hand)), delay(session.settings(), kDelayRange) {}
};

ScriptedTouch::ScriptedTouch(const Scene& scene, const std::string& hand, double rate)
    : scene_(scene), hand_(hand), rate_(rate) {
  scene_.servo.cutting = false;
}
ScriptedTouch::~ScriptedTouch() = default;

Felt ScriptedTouch::feel(const Stimulus& stimulus) {
  const std::unique_ptr<haptics::HapticDevice> hand = open_unpaced_hand(scene_, hand_, rate_);
  std::unique_ptr<Loop>& loop = loops_[stimulus.model];
  if (!loop) {
    Scene scene = scene_;
    choose_model(scene, stimulus.model);
    loop = std::make_unique<Loop>(scene, hand->info());
  }
  SessionSettings settings;
  settings.stiffness = SessionSettings::every_tissue(stimulus.stiffness_ratio);
  loop->session.servo().set_stiffness(settings.stiffness_of(loop->scene.servo.materials));

  haptics::HandSample sample;
  const ServoTick& tick = loop->session.last();
  dvec3 touched_at(0), normal(0);
  Nanos touched = -1;
  double force_depth = 0, depth_depth = 0;
  std::vector<std::pair<Nanos, double>> forces;
  Felt felt;
  bool first = true;
  const Nanos begin = loop->ended + (loop->ended > 0 ? kPause : 0);
  while (hand->read(sample)) {
    sample.t += begin;
    loop->session.tick(sample);
    if (first && inside(tick)) throw Error(hand_, "first row", "a tool in the tissue", "a path that begins in the air");
    first = false;
    const haptics::ForceDelay::Wrench wrench = loop->delay.pass(tick, from_seconds(stimulus.delay));
    const dvec3 force = stimulus.force_fraction * wrench.f_T_W;
    hand->write(force, stimulus.force_fraction * wrench.tau_T_W);
    hand->see(tick);
    if (touched < 0 && tick.depth > 0) touched = sample.t, touched_at = tick.X_WT.p, normal = tick.n_C_W;
    if (touched < 0) continue;
    const double push = glm::dot(force, normal), depth = glm::dot(touched_at - tick.X_WT.p, normal);
    if (tick.depth > 0 && depth > 0) force_depth += push * depth, depth_depth += depth * depth;
    forces.emplace_back(sample.t, glm::length(force));
    felt.force = std::max(felt.force, forces.back().second);
  }
  loop->ended = sample.t;
  if (inside(tick)) throw Error(hand_, "last row", "a tool in the tissue", "a path that ends in the air");
  if (!(felt.force > 0)) throw Error(hand_, "", "a hand that feels no force", "a path that touches the tissue");
  felt.stiffness = depth_depth > 0 ? force_depth / depth_depth : 0;
  const auto onset =
      std::find_if(forces.begin(), forces.end(), [&](const auto& at) { return at.second >= kTouched * felt.force; });
  felt.delay = to_seconds(onset->first - touched);
  return felt;
}

double ScriptedTouch::measured_difference(Question question, const Trial& trial) {
  const Felt first = feel(trial.stimuli[0]), second = feel(trial.stimuli[1]);
  switch (question) {
    case Question::kDelay:
      return 1e3 * (second.delay - first.delay);
    case Question::kForce:
      return signed_percent(trial, first.force, second.force);
    case Question::kStiffness:
    case Question::kModel:
      break;
  }
  return signed_percent(trial, first.stiffness, second.stiffness);
}

}  // namespace typodont

// What each contact model survives: hostile hands, invalid input, a late carver, an uneven clock, a push of 200 N, fast
// probes and thin walls. Each counter NAME has a counter NAME.limit with the largest value that passes.
#include <array>
#include <random>

#include "tests/bench/haptic_scene.h"
#include "tests/bench/model_cases.h"
#include "tests/support/erratic_hand.h"

namespace typodont::bench {

namespace {

using test::HapticBench;
using test::ModelTissue;

constexpr double kHostileLimit = 8;  // N, force limit with erratic hands

/// What a hand felt.
struct Felt {
  double max_force = 0, over_limit = 0;  // N
  double energy = 0;                     // J, largest energy that the force gave to the hand
  // N per tick, largest change of the force beyond 1.5 × stiffness × displacement of the hand
  double step = 0;
  int not_finite = 0;  // ticks
  int passed = 0;      // ticks without force in the tissue, or hands that came through it

  void worse_of(const Felt& other) {
    max_force = std::max(max_force, other.max_force), over_limit = std::max(over_limit, other.over_limit);
    energy = std::max(energy, other.energy), step = std::max(step, other.step);
    not_finite += other.not_finite, passed += other.passed;
  }
};

/// A scene whose ticks are judged.
class Run {
 public:
  Run(haptics::TissueVolume tissue, const haptics::ServoSettings& settings)
      : scene(std::move(tissue), settings, even_materials()) {}

  /// Computes a tick, `dt` s after the last one. `judged`: false if its force step does not count.
  const ServoTick& tick(const Pose& X_WT, double pedal, double dt, bool judged = true) {
    scene.t += from_seconds(dt);
    scene.steps.tick({scene.t, X_WT, pedal}, scene.last, scene.cut);
    const ServoTick& tick = scene.last;
    if (!is_finite(tick.f_T_W) || !is_finite(tick.tau_T_W) || !is_finite(tick.X_WG.p) || !std::isfinite(tick.energy)) {
      ++felt.not_finite;
      return tick;
    }
    const double force = glm::length(tick.f_T_W);
    felt.max_force = std::max(felt.max_force, force);
    const double over = force - scene.settings.force_limit;
    if (over > 1e-9 * scene.settings.force_limit) felt.over_limit = std::max(felt.over_limit, over);
    felt.energy = std::max(felt.energy, -tick.energy);
    if (judged) {
      const double way = is_finite(X_WT.p) ? glm::length(X_WT.p - hand_) : 0;
      felt.step = std::max(felt.step, glm::length(tick.f_T_W - force_) - 1.5 * scene.settings.stiffness * way);
    }
    hand_ = X_WT.p, force_ = tick.f_T_W;
    return tick;
  }

  HapticBench scene;
  Felt felt;

 private:
  dvec3 hand_{0}, force_{0};
};

/// A simulated hand: a mass with a damper.
struct Mass {
  double mass = 0.15, damping = 5;  // kg, N·s/m
  dvec3 x{0}, v{0};
  void step(const dvec3& pull, const dvec3& force, double dt) {
    v += dt * (pull - damping * v + force) / mass;
    x += dt * v;
  }
};

/// Reports the results of one campaign with one model. The default model must survive the short campaigns.
class Report {
 public:
  Report(benchmark::State& state, std::string model) : state_(state), model_(std::move(model)) {}
  void add(const std::string& measure, double value, double limit) {
    state_.counters[measure] = value;
    state_.counters[measure + ".limit"] = limit;
    if (model_ == "offset" && smoke())
      require(value <= limit, fmt::format("the default model survives: {} {:g}, limit {:g}", measure, value, limit));
  }
  void add_sense(const Felt& felt) {
    state_.counters["greatest_force_N"] = felt.max_force;
    add("not_finite_ticks", felt.not_finite, 0);
    add("beyond_limit_N", felt.over_limit, 0);
  }
  void add_energy(const Felt& felt) { add("energy_nJ", 1e9 * std::max(0.0, felt.energy), 1); }

 private:
  benchmark::State& state_;
  std::string model_;
};

haptics::ServoSettings settings_for(const std::string& model, double diameter) {
  haptics::ServoSettings s;
  s.tool = round_head(diameter);
  s.method = default_setting(model).method;
  s.spindle.free_speed = 300 * kKrpm;
  return s;
}

/// Hands that wander, rotate the tool and drill. `nonsense`: one tick in fifty has invalid input.
void hostile(Report report, const std::string& model, bool nonsense) {
  Felt worst;
  for (const auto& [solids, top] : {std::pair(kBall, kBallRadius), std::pair(kBlock, kBlockTop)}) {
    for (int hand = 0; hand < (smoke() ? 1 : 6); ++hand) {
      haptics::ServoSettings s = settings_for(model, 1.2e-3);
      s.force_limit = kHostileLimit;
      Run run(haptics::TissueVolume(tissue(solids, kDefaultVoxel)), s);
      const dvec3 home(0, 0, top);
      test::ErraticHand wanderer(static_cast<std::uint64_t>(hand) + 1, home);
      test::InvalidInput spoiler(static_cast<std::uint64_t>(hand) + 100, home);
      for (int i = 0; i < (smoke() ? 600 : 3000); ++i) {
        Pose X = wanderer.next(1e-3);
        X.p.z += 3e-3 * std::max(0.0, 1 - 1e-3 * i / 0.3);  // no tool starts inside tissue
        double pedal = hand % 2;
        if (nonsense) {
          const test::InvalidInput::Other other = spoiler.spoil(wanderer, X, pedal);
          run.scene.t += other.clock;
          if (other.undo) run.scene.carver.undo();
        }
        run.tick(X, pedal, 1e-3, /*judged=*/false);
      }
      worst.worse_of(run.felt);
    }
  }
  report.add_sense(worst);
  if (!nonsense) report.add_energy(worst);  // the hand was never at invalid poses
}

enum class Gesture { kSlide, kDrill, kTap };
constexpr std::array kGestures{Gesture::kSlide, Gesture::kDrill, Gesture::kTap};

/// A hand that slides, drills or knocks on a block. The carver stalls for `stall` s. Each period of the clock differs
/// from 1 ms by up to the fraction `jitter`, and one period of a hundred then lasts 5 ms.
Felt work(const std::string& model, Gesture gesture, double stall, double jitter) {
  haptics::ServoSettings s = settings_for(model, 1.2e-3);
  s.friction = false;
  Run run(haptics::TissueVolume(tissue(kBlock, kDefaultVoxel)), s);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> either_way(-jitter, jitter);
  const double push =
      model == "voxel_penalty" ? 0.3 : 0.6;  // N; a stronger push passes through the block without proxy
  const double rest = kBlockTop + 0.6e-3;    // m, height of the centre of a head that touches
  Mass hand;
  hand.x = dvec3(0, 0, rest + 0.1e-3);
  const double begin = 0.5, end = begin + std::max(stall, 0.2) + 0.5;
  double t = 0;
  for (int i = 0; t < end && hand.x.z > -kBlockTop; ++i) {
    const double dt = jitter > 0 && i % 100 == 99 ? 5e-3 : 1e-3 * (1 + either_way(random));
    t += dt;
    run.scene.steps.stall(stall > 0 && t > begin && t < begin + stall);
    const double lift = gesture == Gesture::kTap ? 0.3e-3 + 0.6e-3 * std::cos(2 * kPi * 3 * t) : 0;
    dvec3 pull = 2000.0 * (dvec3(0.8e-3 * std::sin(2 * kPi * 0.7 * t), 0, rest + lift) - hand.x);
    if (gesture != Gesture::kTap) pull.z = -push;
    hand.step(pull, run.scene.last.f_T_W, dt);
    run.tick({hand.x}, gesture == Gesture::kDrill ? 1 : 0, dt, t > begin);
  }
  run.felt.passed = hand.x.z < -kBlockTop;
  return run.felt;
}

void stalls(Report report, const std::string& model) {
  Felt worst;
  double step = 0;
  for (const Gesture gesture : kGestures) {
    const Felt without = work(model, gesture, 0, 0);
    for (const double stall : smoke() ? std::vector{0.2} : std::vector{0.05, 0.2, 1.0, 3.0}) {
      const Felt felt = work(model, gesture, stall, 0);
      worst.worse_of(felt);
      step = std::max(step, felt.step - std::max(without.step, 0.0));
    }
  }
  report.add_sense(worst);
  report.add_energy(worst);
  report.add("step_beyond_calm_N", step, 0.25);
  report.add("hands_through", worst.passed, 0);
}

void uneven_clock(Report report, const std::string& model) {
  Felt worst;
  for (const Gesture gesture : kGestures)
    for (const double jitter : {0.2, 0.5}) worst.worse_of(work(model, gesture, 0, jitter));
  report.add_sense(worst);
  report.add_energy(worst);
  report.add("hands_through", worst.passed, 0);
}

/// A hand of 1 kg presses a head of Ø20 mm with 200 N onto a ball of bone. The head slides, and reams.
void heavy(Report report, const std::string& model) {
  constexpr double kPush = 200, kRadius = 30e-3, kHead = 20e-3;
  Felt worst;
  double off = 0;
  for (const bool reams : {false, true}) {
    haptics::ServoSettings s = settings_for(model, kHead);
    s.stiffness = 60e3, s.damping = 20, s.force_limit = 250, s.torque_limit = 10;
    s.spindle.free_speed = 0.3 * kKrpm;
    s.friction = false;
    Run run(haptics::TissueVolume(haptics::read_solids(Json::parse(
                R"({"voxel_mm": 1, "band_mm": 5, "solids": [{"tissue": "cancellous_bone", "solid": {"sphere":
                {"radius_mm": 30}}}]})",
                "bench"))),
            s);
    Mass hand{1, 60, dvec3(0, 0, kRadius + kHead / 2 + 0.2e-3)};
    double sum = 0;
    int count = 0;
    for (int i = 0; i < (smoke() ? 600 : 2000); ++i) {
      const double t = 1e-3 * i, aside = reams ? 0 : 2e-3 * std::sin(2 * kPi * 0.5 * t);
      dvec3 pull = 60e3 * (dvec3(aside, 0, 0) - hand.x);
      pull.z = -kPush * std::min(1.0, t / 0.2);
      hand.step(pull, run.scene.last.f_T_W, 1e-3);
      run.tick({hand.x}, reams ? 1 : 0, 1e-3, false);
      if (t >= 0.4) sum += run.scene.last.f_T_W.z, ++count;
    }
    worst.worse_of(run.felt);
    if (!reams) off = std::abs(sum / count / kPush - 1);
  }
  report.add_sense(worst);
  report.add_energy(worst);
  report.add("force_error_percent", 100 * off, 5);
}

/// An explorer's tip, half of its radius deep, slides over edges, a groove and the dental arch at 30 to 120 mm/s.
void fast_probe(Report report, const std::string& model) {
  constexpr double kTip = 0.125e-3;     // m, radius
  constexpr std::size_t kLanded = 200;  // ticks until the tip is on the surface
  constexpr double kMinForce = 0.02;    // N
  std::vector<ModelTissue> tissues;
  for (ModelTissue& tissue : test::analytic_tissues())
    if (tissue.name == "box edges" || tissue.name == "groove") tissues.push_back(std::move(tissue));
  if (!smoke()) tissues.push_back(load_anatomy(anatomies()[1]));
  Felt worst;
  double squares = 0;
  int count = 0;
  for (const ModelTissue& tissue : tissues) {
    // A hand that is n times as fast takes every n-th position of the path.
    const test::Course course = test::slide_course(tissue, smoke() ? 700 : 1500, {kTip, kTip / 2, 30e-3});
    for (const std::size_t stride : {1, 2, 4}) {
      haptics::ServoSettings s = settings_for(model, 2 * kTip);
      s.cutting = s.friction = false;
      s.damping = 0;
      Run run(tissue.make(tissue.voxels_mm.empty() ? kDefaultVoxel : tissue.voxels_mm.back()), s);
      for (std::size_t k = 0; k < course.hand.size(); k += k < kLanded ? 1 : stride) {
        const double force = glm::length(run.tick({course.hand[k]}, 0, 1e-3, false).f_model_W);
        const double truth = s.stiffness * glm::distance(course.truth[k], course.hand[k]);
        if (k < kLanded || !(truth > kMinForce)) continue;
        run.felt.passed += force < 0.1 * kMinForce;
        squares += (force / truth - 1) * (force / truth - 1), ++count;
      }
      worst.worse_of(run.felt);
    }
  }
  report.add_sense(worst);
  report.add_energy(worst);
  report.add("holes_ticks", worst.passed, 0);
  report.add("force_error_percent", 100 * std::sqrt(squares / std::max(count, 1)), 25);
}

/// Hands that pass through a sheet of 0.3 mm by 1 mm per tick. A hand escapes if no force then pulls it back.
void thin_wall(Report report, const std::string& model) {
  haptics::ServoSettings s = settings_for(model, 2 * test::kProbeRadius);
  s.friction = s.cutting = false;
  Run run(test::sheet_tissue(0.3).make(kDefaultVoxel), s);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  const int hands = smoke() ? 5 : 50;
  int escaped = 0;
  for (int k = 0; k < hands; ++k) {
    const double x = anywhere(random), y = anywhere(random), lean = 0.2 * anywhere(random);
    const dvec3 from(1e-3 * x, 1e-3 * y, 3e-3), way(1e-3 * lean, 0, -1e-3);
    for (int i = 0; i < 3; ++i)
      run.tick({dvec3(0, 0, 0.2)}, 0, 1e-3);  // far away, so that the last contact is forgotten
    for (int i = 0; i < 20; ++i) run.tick({from}, 0, 1e-3);
    dvec3 hand = from;
    while (hand.z > -4e-3) run.tick({hand += way}, 0, 1e-3);
    for (int i = 0; i < 50; ++i) run.tick({hand}, 0, 1e-3);
    escaped += run.scene.last.f_T_W.z < 0.1;
  }
  report.add("escaped_percent", 100.0 * escaped / hands, 0);
}

}  // namespace

void add_cases() {
  for (const std::string& model : haptics::contact_method_names()) {
    if (smoke() && model != "offset" && model != "voxel_penalty") continue;
    const auto campaign = [&](const char* name, const std::function<void(Report, const std::string&)>& run) {
      add(fmt::format("{}/{}", name, model), [=](benchmark::State& state) { run(Report(state, model), model); });
    };
    campaign("hostile hand", [](Report report, const std::string& of) { hostile(report, of, false); });
    campaign("nonsense", [](Report report, const std::string& of) { hostile(report, of, true); });
    campaign("carver stalls", stalls);
    campaign("uneven clock", uneven_clock);
    campaign("200 N", heavy);
    campaign("fast probe", fast_probe);
    campaign("thin wall", thin_wall);
  }
}

}  // namespace typodont::bench

// The command `typodont bench stress`. It measures difficult conditions that a contact model must survive. The name of
// a row consists of the kind of test, the model and the measured quantity. The column `ratio` is the measured value
// divided by the largest permitted value. So a model passes if the ratio is at most 1.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/model_settings.h"
#include "haptics/bench/model_tissues.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/wanderer.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"

namespace typodont::haptics {

namespace {

using namespace bench;

// J, largest energy that a hand may receive; the servo's passivity controller guarantees this limit
constexpr double kMostEnergy = 1e-9;
// N per tick. The largest force step (Felt::step) is measured in two runs: with a carver thread that stops for a while,
// and with a carver thread that never stops. The two values may differ by at most this.
constexpr double kMostStep = 0.25;
constexpr double kHostileLimit = 8;  // N, force limit for tests with erratic hands
constexpr std::string_view kBlock6 = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}])";
constexpr double kBlock6Top = 2e-3;  // m, height of the block's surface

/// The values that were measured in a run.
struct Felt {
  int ticks = 0, not_finite = 0;
  double most_force = 0;  // N, largest force in the run
  double over_limit = 0;  // N, largest excess over the force limit
  double energy = 0;      // J, largest energy that the force gave to the hand
  // N per tick, largest change of the force from tick to tick that the hand's motion does not explain: the change minus
  // 1.5 × stiffness × displacement of the hand
  double step = 0;
  double last_force = 0, depth = 0;  // force in N and penetration depth in m in the last tick
  // Number of ticks without force although the tool was inside the tissue. In work(): 1 if the hand came through the
  // block, otherwise 0.
  int holes = 0;

  void worse_of(const Felt& other) {
    ticks += other.ticks, not_finite += other.not_finite, holes += other.holes;
    most_force = std::max(most_force, other.most_force);
    over_limit = std::max(over_limit, other.over_limit);
    energy = std::max(energy, other.energy);
    step = std::max(step, other.step);
  }
};

/// Servo and carver (owner of the tissue) with a hand, and the values that are measured.
class Run {
 public:
  Run(TissueVolume tissue, const ServoSettings& settings)
      : steps_(std::move(tissue), settings), settings_(steps_.settings()) {}

  /// Computes one tick, `dt` s after the previous tick. If `judged` is false, the change of the force in this tick is
  /// not included in Felt::step (the largest force step).
  const ServoTick& tick(const Pose& X_WT, double pedal, double dt, bool judged = true) {
    t_ += from_seconds(dt);
    Cut cut;
    steps_.tick({t_, X_WT, pedal}, tick_, cut);
    see(X_WT.p, judged);
    return tick_;
  }
  void jump_clock(Nanos by) { t_ += by; }
  void stall(bool stalled) { steps_.stall(stalled); }
  const ServoTick& last() const { return tick_; }
  Carver& carver() { return steps_.carver(); }
  const Felt& felt() const { return felt_; }
  double stiffness() const { return settings_.stiffness; }

 private:
  void see(const dvec3& hand, bool judged) {
    ++felt_.ticks;
    const bool finite = is_finite(tick_.f_T_W) && is_finite(tick_.tau_T_W) && is_finite(tick_.X_WG.p) &&
                        std::isfinite(tick_.energy) && std::isfinite(tick_.depth);
    felt_.not_finite += !finite;
    if (!finite) return;
    const double force = glm::length(tick_.f_T_W);
    felt_.most_force = std::max(felt_.most_force, force);
    felt_.over_limit = std::max(felt_.over_limit, force - settings_.force_limit);
    felt_.energy = std::max(felt_.energy, -tick_.energy);
    if (judged) {
      const double way = is_finite(hand) ? glm::length(hand - hand_) : 0;
      felt_.step = std::max(felt_.step, glm::length(tick_.f_T_W - force_) - 1.5 * settings_.stiffness * way);
    }
    hand_ = hand, force_ = tick_.f_T_W;
    felt_.last_force = force, felt_.depth = tick_.depth;
  }

  LockStep steps_;
  const ServoSettings& settings_;
  ServoTick tick_;
  Felt felt_;
  Nanos t_ = 0;
  dvec3 hand_{0}, force_{0};
};

/// A simulated hand: a mass with a damper, pulled by an external force.
struct Mass {
  double mass = 0.15, damping = 5;  // mass of the simulated hand in kg, and its damping in N·s/m
  dvec3 x{0}, v{0};

  void step(const dvec3& pull, const dvec3& force, double dt) {
    v += dt * (pull - damping * v + force) / mass;
    x += dt * v;
  }
};

enum class Gesture { kSlide, kDrill, kTap };
constexpr std::array kGestures{Gesture::kSlide, Gesture::kDrill, Gesture::kTap};

class Stress {
 public:
  Stress(const StressBenchOptions& options, const std::string& model, std::vector<BenchRow>& rows)
      : options_(options), model_(model), usual_(default_method(model)), rows_(rows) {}

  void all() {
    hostile(false);
    hostile(true);
    stalls();
    uneven_clock();
    heavy();
    fast_probe();
    thin_wall();
  }

 private:
  /// Adds a row. `most` is the largest permitted value. If `most` is 0, the test fails with every value above 0. If
  /// `most` is infinite, the value is only reported and cannot fail.
  void add(const char* campaign, const char* measure, double value, const char* unit, double most) {
    BenchRow row;
    row.name = fmt::format("{}, {}: {}", campaign, model_, measure);
    row.knob = usual_.knob;
    row.error = value, row.error_unit = unit;
    row.baseline = most == 0             ? "none passes"
                   : std::isfinite(most) ? fmt::format("the most that passes, {:g}", most)
                                         : "told only";
    row.ratio = most > 0 ? value / most : (value > 0 ? 1 + value : 0);
    rows_.push_back(std::move(row));
  }
  void add_sense(const char* campaign, const Felt& felt) {
    add(campaign, "greatest force", felt.most_force, "N", std::numeric_limits<double>::infinity());
    add(campaign, "not finite", felt.not_finite, "ticks", 0);
    add(campaign, "beyond the limit", felt.over_limit > 1e-9 * kHostileLimit ? felt.over_limit : 0, "N", 0);
  }
  void add_energy(const char* campaign, const Felt& felt) {
    add(campaign, "energy given", 1e9 * std::max(0.0, felt.energy), "nJ", 1e9 * kMostEnergy);
  }
  void add_step(const char* campaign, const Felt& felt) {
    add(campaign, "step", std::max(0.0, felt.step), "N per tick more than without the disturbance", kMostStep);
  }

  ServoSettings settings(double diameter) const {
    ServoSettings s;
    s.tool = head(HeadShape::kSphere, diameter, diameter);
    s.method = usual_.method;
    for (Material& material : s.materials) material = {1000, 8e9, 0.2, 0.15, 2150, dvec3(0.8)};
    return s;
  }

  /// Tests hands that wander, rotate the tool and drill. If `nonsense` is true, one tick in fifty has invalid input, as
  /// from a broken device or clock.
  void hostile(bool nonsense) {
    const char* campaign = nonsense ? "nonsense" : "hostile hand";
    const int hands = options_.quick ? 1 : 6, ticks = options_.quick ? 600 : 3000;
    Felt worst;
    for (const auto& [solids, top] : {std::pair(bench::kBall, kBallRadius), std::pair(kBlock6, kBlock6Top)}) {
      for (int hand = 0; hand < hands; ++hand) {
        ServoSettings s = settings(1.2e-3);
        s.spindle.free_speed = 300 * kKrpm;
        s.force_limit = kHostileLimit;
        Run run(TissueVolume(tissue(solids, kDefaultVoxel)), s);
        const dvec3 home(0, 0, top);
        ErraticHand wanderer(static_cast<std::uint64_t>(hand) + 1, home);
        InvalidInput spoiler(static_cast<std::uint64_t>(hand) + 100, home);
        for (int i = 0; i < ticks; ++i) {
          Pose X = wanderer.next(1e-3);
          // the first positions are in the air, because no tool starts inside tissue
          X.p.z += 3e-3 * std::max(0.0, 1 - 1e-3 * i / 0.3);
          double pedal = hand % 2;
          if (nonsense) {
            const InvalidInput::Other other = spoiler.spoil(wanderer, X, pedal);
            run.jump_clock(other.clock);
            if (other.undo) run.carver().undo();
          }
          run.tick(X, pedal, 1e-3, /*judged=*/false);
        }
        worst.worse_of(run.felt());
      }
    }
    add_sense(campaign, worst);
    // after invalid poses, the energy is not evaluated, because the hand was never at these poses
    if (!nonsense) add_energy(campaign, worst);
  }

  /// Tests a hand that slides, drills or knocks on a block. The carver's thread stops for `stall` s (0: it never
  /// stops). Each period of the clock differs from 1 ms by up to the fraction `jitter`. If `jitter` is not 0, one
  /// period of a hundred lasts 5 ms.
  Felt work(Gesture gesture, double stall, double jitter) const {
    ServoSettings s = settings(1.2e-3);
    s.spindle.free_speed = 300 * kKrpm;
    s.friction = false;
    Run run(TissueVolume(tissue(kBlock6, kDefaultVoxel)), s);
    std::mt19937_64 random(5);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    // N; voxel_penalty has no proxy, so a stronger push would pass through the block (see its README)
    const double push = model_ == "voxel_penalty" ? 0.3 : 0.6;
    Mass hand;
    const double rest = kBlock6Top + 0.6e-3;  // m, height of the centre of a head that touches the block
    hand.x = dvec3(0, 0, rest + 0.1e-3);
    const double begin = 0.5, end = begin + std::max(stall, 0.2) + 0.5;
    double t = 0;
    for (int i = 0; t < end; ++i) {
      double dt = 1e-3 * (1 + jitter * (2 * uniform() - 1));
      if (jitter > 0 && i % 100 == 99) dt = 5e-3;
      t += dt;
      run.stall(stall > 0 && t > begin && t < begin + stall);
      const double aside = 0.8e-3 * std::sin(2 * kPi * 0.7 * t);
      const double lift = gesture == Gesture::kTap ? 0.3e-3 + 0.6e-3 * std::cos(2 * kPi * 3 * t) : 0;
      dvec3 pull = 2000.0 * (dvec3(aside, 0, rest + lift) - hand.x);
      if (gesture != Gesture::kTap) pull.z = -push;
      hand.step(pull, run.last().f_T_W, dt);
      run.tick({hand.x}, gesture == Gesture::kDrill ? 1 : 0, dt, t > begin);
      if (hand.x.z < -kBlock6Top) break;  // the hand has come through the block
    }
    Felt felt = run.felt();
    felt.holes = hand.x.z < -kBlock6Top;
    return felt;
  }

  void stalls() {
    constexpr const char* kCampaign = "carver stalls";
    Felt worst;
    double step = 0;
    for (const Gesture gesture : kGestures) {
      const Felt without = work(gesture, 0, 0);
      for (const double stall : options_.quick ? std::vector{0.2} : std::vector{0.05, 0.2, 1.0, 3.0}) {
        const Felt felt = work(gesture, stall, 0);
        worst.worse_of(felt);
        step = std::max(step, felt.step - std::max(without.step, 0.0));
      }
    }
    worst.step = step;
    add_sense(kCampaign, worst);
    add_energy(kCampaign, worst);
    add_step(kCampaign, worst);
    add(kCampaign, "came through", worst.holes, "hands", 0);
  }

  void uneven_clock() {
    constexpr const char* kCampaign = "uneven clock";
    Felt worst;
    for (const Gesture gesture : kGestures)
      for (const double jitter : {0.2, 0.5}) worst.worse_of(work(gesture, 0, jitter));
    add_sense(kCampaign, worst);
    add_energy(kCampaign, worst);
    add(kCampaign, "came through", worst.holes, "hands", 0);
  }

  /// Tests a head of Ø20 mm on a ball of bone. A hand of 1 kg presses it with 200 N. The head rests, slides, and reams.
  void heavy() {
    constexpr const char* kCampaign = "200 N";
    constexpr double kPush = 200, kRadius = 30e-3, kHead = 20e-3;
    Felt worst;
    double off = 0;
    for (const bool reams : {false, true}) {
      ServoSettings s = settings(kHead);
      s.stiffness = 60e3, s.damping = 20;
      s.force_limit = 250, s.torque_limit = 10;
      s.spindle.free_speed = 0.3 * kKrpm;
      s.friction = false;
      Run run(TissueVolume(read_solids(Json::parse(
                  R"({"voxel_mm": 1, "band_mm": 5, "solids": [{"tissue": "cancellous_bone", "solid": {"sphere":
                  {"radius_mm": 30}}}]})",
                  "bench"))),
              s);
      Mass hand{1, 60, dvec3(0, 0, kRadius + kHead / 2 + 0.2e-3)};
      const int ticks = options_.quick ? 600 : 2000;
      double sum = 0;
      int count = 0;
      for (int i = 0; i < ticks; ++i) {
        const double t = 1e-3 * i, aside = reams ? 0 : 2e-3 * std::sin(2 * kPi * 0.5 * t);
        dvec3 pull = 60e3 * (dvec3(aside, 0, 0) - hand.x);
        pull.z = -kPush * std::min(1.0, t / 0.2);
        hand.step(pull, run.last().f_T_W, 1e-3);
        run.tick({hand.x}, reams ? 1 : 0, 1e-3, false);
        if (t < 0.4) continue;
        sum += run.last().f_T_W.z, ++count;
      }
      worst.worse_of(run.felt());
      if (!reams) off = std::abs(sum / count / kPush - 1);
    }
    add_sense(kCampaign, worst);
    add_energy(kCampaign, worst);
    add(kCampaign, "force off", 100 * off, "% of 200 N, mean", 5);
  }

  /// Tests an explorer's tip that slides over edges, a groove and the meshes of the anatomies at 30 to 120 mm/s. The
  /// tip is half of its radius deep. At an edge, a deeper tip could also touch the other face; then there would be two
  /// correct forces.
  void fast_probe() {
    constexpr const char* kCampaign = "fast probe";
    constexpr double kTip = 0.125e-3;     // m, radius of the probe's tip
    constexpr std::size_t kLanded = 200;  // number of ticks after which the tip is on the surface
    constexpr double kLeast = 0.02;       // N; a smaller force does not count as contact
    std::vector<ModelTissue> tissues;
    for (ModelTissue& tissue : analytic_tissues())
      if (tissue.name == "box edges" || tissue.name == "groove") tissues.push_back(std::move(tissue));
    for (const ModelAnatomy& mesh : options_.meshes) tissues.push_back(mesh_tissue(mesh));
    Felt worst;
    double squares = 0;
    int count = 0;
    for (const ModelTissue& tissue : tissues) {
      // The path was computed for the slow hand. A hand that is n times as fast uses every n-th position of this path.
      const Course course = slide_course(tissue, options_.quick ? 700 : 1500, {kTip, kTip / 2, 30e-3});
      for (const std::size_t stride : {1, 2, 4}) {
        ServoSettings s = settings(2 * kTip);
        s.cutting = s.friction = false;
        s.damping = 0;
        Run run(tissue.make(tissue.voxels_mm.empty() ? kDefaultVoxel : tissue.voxels_mm.back()), s);
        int holes = 0;
        for (std::size_t k = 0; k < course.hand.size(); k += k < kLanded ? 1 : stride) {
          const double force = glm::length(run.tick({course.hand[k]}, 0, 1e-3, false).f_model_W);
          const double truth = s.stiffness * glm::distance(course.truth[k], course.hand[k]);
          if (k < kLanded || !(truth > kLeast)) continue;
          holes += force < 0.1 * kLeast;
          squares += (force / truth - 1) * (force / truth - 1), ++count;
        }
        worst.worse_of(run.felt());
        worst.holes += holes;
      }
    }
    add_sense(kCampaign, worst);
    add_energy(kCampaign, worst);
    add(kCampaign, "holes", worst.holes, "ticks without force in the tissue", 0);
    add(kCampaign, "force off", 100 * std::sqrt(squares / std::max(count, 1)), "%, rms", 25);
  }

  /// Moves hands by 1 mm per tick through a sheet with a thickness of 0.3 mm. Measures how many hands escape: on the
  /// other side of the sheet, no force pulls them back.
  void thin_wall() {
    ServoSettings s = settings(2 * kProbeRadius);
    s.friction = s.cutting = false;
    Run run(sheet_tissue(0.3).make(kDefaultVoxel), s);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> anywhere(-1, 1);
    const int hands = options_.quick ? 5 : 50;
    int escaped = 0;
    for (int k = 0; k < hands; ++k) {
      const double x = anywhere(random), y = anywhere(random), lean = 0.2 * anywhere(random);
      const dvec3 from(1e-3 * x, 1e-3 * y, 3e-3), way(1e-3 * lean, 0, -1e-3);
      // Moves the hand far away, so that the model forgets the last contact.
      for (int i = 0; i < 3; ++i) run.tick({dvec3(0, 0, 0.2)}, 0, 1e-3);
      for (int i = 0; i < 20; ++i) run.tick({from}, 0, 1e-3);
      dvec3 hand = from;
      while (hand.z > -4e-3) run.tick({hand += way}, 0, 1e-3);
      for (int i = 0; i < 50; ++i) run.tick({hand}, 0, 1e-3);
      escaped += run.last().f_T_W.z < 0.1;
    }
    add("thin wall", "escaped", 100.0 * escaped / hands, "% of the hands", 0);
  }

  const StressBenchOptions& options_;
  std::string model_;
  DefaultMethod usual_;
  std::vector<BenchRow>& rows_;
};

}  // namespace

std::vector<BenchRow> bench_stress(const StressBenchOptions& options) {
  std::vector<BenchRow> rows;
  for (const std::string& model : contact_method_names()) {
    const bool wanted = options.models.empty() || std::ranges::count(options.models, model) > 0;
    if (wanted) Stress(options, model, rows).all();
  }
  return rows;
}

}  // namespace typodont::haptics

// Measures the critical stiffness, above which a simulated hand vibrates at a sampled wall. The real servo is compared
// with the exact solution of the linear problem. Also measures how the passivity controller changes the motion at
// stiffer walls.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "engine/app/bench/carver_stalls.h"
#include "engine/app/bench/parts.h"
#include "engine/app/haptic_loop.h"
#include "engine/app/recording/resume.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using namespace literals;

// The simulated hand is a mass with a damper (Colgate & Brown 1994). A constant force presses it against the wall, so
// that it stays in contact while its vibration is small. kMass: kg, mass of the hand; kDamping: N·s/m, damper; kPush:
// N, constant force.
constexpr double kMass = 0.15, kDamping = 5, kPush = 4;
constexpr int kMostDelay = 2;

struct Course {
  // true: the hand is unstable: its vibration is larger in the last quarter of the run than in the second, or the hand
  // leaves the wall
  bool grows = false;
  double least_energy = 0;  // J, smallest value of the energy ledger
};

/// Timing of the simulated servo: rate, delay of the force, and jitter (variation of the time between two ticks).
struct Clock {
  double rate = 1000;  // Hz, rate of the servo
  int delay = 0;       // number of ticks from the computation of a force to its effect
  double jitter = 0;   // largest deviation of a period from its mean, as a fraction of the period
};

/// Simulates a hand at a wall. `wall` is a function that returns the force (N) of the wall; its arguments are the
/// hand's height above the surface (m) and the time since the previous tick (s). Between two ticks, the motion of the
/// hand's mass is integrated exactly.
Course play(double stiffness, const Clock& clock, const std::function<double(double, double)>& wall,
            const std::function<double()>& energy) {
  const double rest = -kPush / stiffness;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> either_way(-clock.jitter, clock.jitter);
  double T = 1 / clock.rate, z = 0.97 * rest, v = 0;
  std::array<double, kMostDelay + 1> force{};
  force.fill(kPush);
  Course course;
  double early = 0, late = 0;
  const int ticks = static_cast<int>(1.2 * clock.rate);
  for (int i = 0; i < ticks; ++i) {
    std::copy_backward(force.begin(), force.end() - 1, force.end());  // shifts the queue of delayed forces by one tick
    force[0] = wall(z, T);
    T = (1 + either_way(random)) / clock.rate;
    const double e = std::exp(-kDamping / kMass * T);
    const double f = force[static_cast<std::size_t>(clock.delay)], end = (f - kPush) / kDamping;
    z += end * T + (v - end) * (1 - e) * kMass / kDamping;
    v = end + (v - end) * e;
    course.least_energy = std::min(course.least_energy, energy());
    const double excursion = std::abs(z - rest);
    if (i >= ticks / 4 && i < ticks / 2) early = std::max(early, excursion);
    if (i >= 3 * ticks / 4) late = std::max(late, excursion);
  }
  course.grows = late > early || late > std::abs(rest);
  return course;
}

Course theory(double stiffness, const Clock& clock) {
  return play(
      stiffness, clock, [&](double z, double) { return -stiffness * z; }, [] { return 0.0; });
}

/// A flat wall and a ball with a diameter of 2 mm that presses on it. `press` moves the ball to a height in m; at
/// height 0 the ball first touches the wall.
class Wall {
 public:
  Wall(double stiffness, double rate, bool controller) : loop_(make(stiffness, rate, controller)) {}
  /// Moves the ball to the height `z` (m) and returns the force, N. `after`: time since the previous call, s.
  double press(double z, double after) {
    haptics::HandSample hand;
    hand.t = t_ += from_seconds(after);
    hand.X_WT.p = dvec3(0.1_mm, 0.1_mm, 1.0_mm + z);
    Cut cut;
    loop_.tick(hand, tick_, cut);
    return tick_.f_T_W.z;
  }
  double energy() const { return tick_.energy; }

 private:
  static HapticLoop make(double stiffness, double rate, bool controller);

  HapticLoop loop_;
  ServoTick tick_;
  Nanos t_ = 0;
};

HapticLoop Wall::make(double stiffness, double rate, bool controller) {
  Scene scene = parse_scene(
      Json::parse(
          fmt::format(
              R"({{"tissue": {{"voxel_mm": 0.4, "domain_mm": [[-4,-4,-8],[4,4,5]], "solids": [{{"tissue": "enamel",
        "solid": {{"halfspace": {{"normal": [0,0,1], "offset_mm": 0}}}}}}]}},
        "tool": {{"shape": "sphere", "diameter_mm": 2, "cuts": false}}, "friction": false, "passivity": {},
        "coupling": {{"stiffness_N_per_mm": {}, "damping_Ns_per_mm": 0}}, "materials": {{"enamel": {{"stiffness_N_per_mm": 1}}}},
        "parts": ["haptics"]}})",
              controller, stiffness * 1e-3),
          "bench"),
      {});
  scene.servo.force_limit = 1e3;
  return HapticLoop(scene, load_tissue(scene), rate);
}

Course servo(double stiffness, const Clock& clock, bool controller) {
  Wall wall(stiffness, clock.rate, controller);
  const auto at = [&](double z, double after) { return wall.press(z, after); };
  // The servo requires that a contact begins outside the tissue, so the hand first approaches at 20 mm/s.
  const double rest = -kPush / stiffness, way = 0.02 / clock.rate;
  for (double z = 0.2_mm; z > 0.97 * rest; z -= way) at(z, 1 / clock.rate);
  return play(stiffness, clock, at, [&] { return wall.energy(); });
}

/// Returns the depth, in m, at which a hand that moves inward at `speed` (m/s) first feels `force` (N). The wall has 1
/// N/mm, and the passivity controller is on.
double first_felt(double speed, double force, double rate) {
  Wall wall(1000, rate, true);
  const double way = speed / rate;
  double z = 0.3_mm;
  while (z > -50e-3 && wall.press(z, 1 / rate) < force) z -= way;
  return -z;
}

/// Returns a lower limit of first_felt(): the smallest depth (m) at which a passivity controller can give `force` (N)
/// at a wall of 1 N/mm, even if it is the best possible one. The energy ledger E must stay above -ε (1 nJ) in the next
/// tick, too. In this tick, the hand may retreat by its last step a, and then takes the energy F a from the ledger. So
/// a force F is allowed only if F a <= E + ε. While the hand moves inward, each tick adds at most F a to E. Therefore
/// the sum E + ε at most doubles per tick.
double least_first_felt(double speed, double force, double rate) {
  constexpr double kCredit = 1e-9;  // J, ε: amount by which the energy ledger may be overdrawn
  const double way = speed / rate;
  return way * std::max(force / (1000 * way), std::ceil(std::log2(std::max(force * way / kCredit, 1.0))));
}

/// Finds the critical stiffness (N/m) by bisection: at a stiffer wall, the vibration of the hand grows.
template <class F>
double critical(double guess, F&& course) {
  double low = 0.2 * guess, high = 5 * guess;
  for (int i = 0; i < 18; ++i) {
    const double middle = std::sqrt(low * high);
    (course(middle).grows ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

/// Adds the rows that show what the hand feels while the carver (the thread that updates the tissue) stalls. Each row
/// belongs to one motion of the hand and one duration of the stall, and contains the worst result of several hands.
void carver_stall_rows(bool quick, std::vector<BenchRow>& rows) {
  const std::vector<double> stalls =
      quick ? std::vector<double>{0.2, 1.0} : std::vector<double>{5e-3, 10e-3, 20e-3, 50e-3, 0.1, 0.2, 0.5, 1, 2, 5};
  const std::vector<double> rates = quick ? std::vector<double>{1000} : std::vector<double>{1000, 4000};
  const std::uint64_t hands = quick ? 1 : 6;
  for (const double rate : rates) {
    for (const StallGesture gesture : kStallGestures) {
      for (const double stall : stalls) {
        StallResult worst;
        for (std::uint64_t seed = 1; seed <= hands; ++seed) {
          const StallResult felt = simulate_stall({gesture, stall, rate, seed});
          worst.worst_step = std::max(worst.worst_step, felt.worst_step);
          worst.energy = std::max(worst.energy, felt.energy);
        }
        const auto row = [&](const char* what, double value, const char* unit) {
          rows.push_back({.name = fmt::format("carver stalls, {}: {}", name_of(gesture), what),
                          .knob = fmt::format("{:g} ms, {:g} Hz, {} hands", stall * 1e3, rate, hands),
                          .error = value,
                          .error_unit = unit,
                          .size = stall * 1e3,
                          .size_unit = "stall, ms"});
        };
        row("largest step", worst.worst_step, "N in a tick");
        row("given to the hand", worst.energy, "J");
      }
    }
  }
}

}  // namespace

std::vector<BenchRow> bench_stability(const BenchRun& run) {
  std::vector<BenchRow> rows;
  const std::vector<double> rates = run.quick ? std::vector<double>{1000} : std::vector<double>{500, 1000, 2000, 4000};
  const auto rate_row = [&](std::string name, double rate, double value, const char* unit) {
    rows.push_back({.name = std::move(name),
                    .knob = fmt::format("{:g} Hz", rate),
                    .error = value,
                    .error_unit = unit,
                    .size = rate,
                    .size_unit = "servo rate, Hz"});
  };
  struct Kind {
    const char* name;
    int delay;
    double jitter;
  };
  for (const Kind& kind : {Kind{"no delay", 0, 0},
                           {"delay of 1 tick", 1, 0},
                           {"delay of 2 ticks", 2, 0},
                           {"jitter of 20 %", 0, 0.2},
                           {"jitter of 50 %", 0, 0.5},
                           {"delay of 1 tick, jitter of 50 %", 1, 0.5}}) {
    for (const double rate : rates) {
      const Clock clock{rate, kind.delay, kind.jitter};
      // N/m, first guess of the critical stiffness, from Colgate's condition: a wall of stiffness K is stable if the
      // damping is b > K (T / 2 + delay), where T is the servo's period
      const double guess = 2 * kDamping * rate / (1 + 2 * kind.delay);
      const double expected = critical(guess, [&](double k) { return theory(k, clock); });
      const double found = critical(guess, [&](double k) { return servo(k, clock, false); });
      const auto row = [&](std::string name, double value, const char* unit) {
        rate_row(std::move(name), rate, value, unit);
      };
      row(fmt::format("theory, {}", kind.name), expected, "critical stiffness, N/m");
      row(fmt::format("servo without the controller, {}", kind.name), found, "critical stiffness, N/m");
      row(fmt::format("servo against theory, {}", kind.name), std::abs(found / expected - 1), "relative");
      if (kind.delay == 0)
        row(fmt::format("energy given by a wall of twice this stiffness, controller on, {}", kind.name),
            std::abs(servo(2 * expected, clock, true).least_energy), "J");
    }
  }
  for (const double rate : {100.0, 200.0, 500.0, 1000.0, 4000.0}) {
    const auto row = [&](const char* name, double depth) { rate_row(name, rate, depth / kMillimetre, "depth, mm"); };
    row("first 0.1 N of a hand at 20 mm/s, controller on", first_felt(20e-3, 0.1, rate));
    row("lower bound for any controller if the hand may reverse", least_first_felt(20e-3, 0.1, rate));
  }
  carver_stall_rows(run.quick, rows);
  return rows;
}

}  // namespace typodont

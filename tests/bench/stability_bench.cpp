// The critical stiffness of a sampled wall, above which a hand vibrates: the servo against the exact solution of the
// linear problem. Also the depth at which a hand first feels a force, and force steps while the carver stalls.
#include <array>
#include <random>

#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "tests/bench/bench.h"
#include "tests/support/carver_stalls.h"

namespace typodont::bench {

namespace {

using namespace literals;

// The hand is a mass with a damper (Colgate & Brown 1994), pressed against the wall. kg, N·s/m, N
constexpr double kMass = 0.15, kDamping = 5, kPush = 4;
constexpr int kMaxDelay = 2;

struct Course {
  bool grows = false;     // the vibration grows, or the hand leaves the wall
  double min_energy = 0;  // J, of the energy ledger
};

/// Timing of the servo.
struct Clock {
  double rate = 1000;  // Hz
  int delay = 0;       // ticks from the computation of a force to its effect
  double jitter = 0;   // largest deviation of a period, as a fraction
};

/// Simulates a hand at a wall; between ticks, its motion is exact. `wall` returns the force (N) at a height (m) and a
/// time since the last tick (s).
Course play(double stiffness, const Clock& clock, const std::function<double(double, double)>& wall,
            const std::function<double()>& energy) {
  const double rest = -kPush / stiffness;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> either_way(-clock.jitter, clock.jitter);
  double T = 1 / clock.rate, z = 0.97 * rest, v = 0, early = 0, late = 0;
  std::array<double, kMaxDelay + 1> force{};
  force.fill(kPush);
  Course course;
  const int ticks = static_cast<int>(1.2 * clock.rate);
  for (int i = 0; i < ticks; ++i) {
    std::copy_backward(force.begin(), force.end() - 1, force.end());
    force[0] = wall(z, T);
    T = (1 + either_way(random)) / clock.rate;
    const double e = std::exp(-kDamping / kMass * T);
    const double end = (force[static_cast<std::size_t>(clock.delay)] - kPush) / kDamping;
    z += end * T + (v - end) * (1 - e) * kMass / kDamping;
    v = end + (v - end) * e;
    course.min_energy = std::min(course.min_energy, energy());
    const double excursion = std::abs(z - rest);
    if (i >= ticks / 4 && i < ticks / 2) early = std::max(early, excursion);
    if (i >= 3 * ticks / 4) late = std::max(late, excursion);
  }
  course.grows = late > early || late > std::abs(rest);
  return course;
}

/// A flat wall and a ball of 2 mm that presses on it.
class Wall {
 public:
  Wall(double stiffness, double rate, bool controller) : session_(make(stiffness, rate, controller)) {}
  /// Moves the ball to a height (m) above its first touch and returns the force, N. `after`: s, since the last call.
  double press(double z, double after) {
    haptics::HandSample hand;
    hand.t = t_ += from_seconds(after);
    hand.X_WT.p = dvec3(0.1_mm, 0.1_mm, 1.0_mm + z);
    return session_.tick(hand).f_T_W.z;
  }
  double energy() const { return session_.last().energy; }

 private:
  static SteppedSession make(double stiffness, double rate, bool controller) {
    Scene scene = parse_scene(
        Json::parse(fmt::format(
                        R"({{"tissue": {{"voxel_mm": 0.4, "domain_mm": [[-4,-4,-8],[4,4,5]], "solids": [{{"tissue":
        "enamel", "solid": {{"halfspace": {{"normal": [0,0,1], "offset_mm": 0}}}}}}]}},
        "tool": {{"shape": "sphere", "diameter_mm": 2, "cuts": false}}, "friction": false, "passivity": {},
        "coupling": {{"stiffness_N_per_mm": {}, "damping_Ns_per_mm": 0}}, "materials": {{"enamel":
        {{"stiffness_N_per_mm": 1}}}}, "parts": ["haptics"]}})",
                        controller, stiffness * 1e-3),
                    "bench"),
        {});
    scene.servo.force_limit = 1e3;
    return SteppedSession(scene, load_tissue(scene), rate);
  }

  SteppedSession session_;
  Nanos t_ = 0;
};

Course servo(double stiffness, const Clock& clock, bool controller) {
  Wall wall(stiffness, clock.rate, controller);
  const auto at = [&](double z, double after) { return wall.press(z, after); };
  // A contact begins outside the tissue: the hand approaches at 20 mm/s.
  const double rest = -kPush / stiffness, way = 0.02 / clock.rate;
  for (double z = 0.2_mm; z > 0.97 * rest; z -= way) at(z, 1 / clock.rate);
  return play(stiffness, clock, at, [&] { return wall.energy(); });
}

/// Returns the depth (m) at which a hand that moves inward at 20 mm/s first feels 0.1 N from a wall of 1 N/mm.
double first_felt(double rate) {
  Wall wall(1000, rate, true);
  double z = 0.3_mm;
  while (z > -50e-3 && wall.press(z, 1 / rate) < 0.1) z -= 20e-3 / rate;
  return -z;
}

/// Returns the critical stiffness (N/m) by bisection.
template <class F>
double critical(double guess, F&& course) {
  double low = 0.2 * guess, high = 5 * guess;
  for (int i = 0; i < 18; ++i) {
    const double middle = std::sqrt(low * high);
    (course(middle).grows ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

void wall_case(benchmark::State& state, const Clock& clock) {
  // N/m, from Colgate's condition: a wall of stiffness K is stable if b > K (T / 2 + delay).
  const double guess = 2 * kDamping * clock.rate / (1 + 2 * clock.delay);
  const double theory = critical(guess, [&](double k) {
    return play(
        k, clock, [&](double z, double) { return -k * z; }, [] { return 0.0; });
  });
  const double found = critical(guess, [&](double k) { return servo(k, clock, false); });
  state.counters["theory_N_per_m"] = theory;
  state.counters["servo_N_per_m"] = found;
  require(std::abs(found / theory - 1) < 0.05, "the servo is as stable as the theory allows");
  if (clock.delay > 0) return;
  state.counters["energy_at_twice_nJ"] = 1e9 * std::abs(servo(2 * theory, clock, true).min_energy);
}

void stall_case(benchmark::State& state, test::StallGesture gesture, double stall) {
  double step = 0, energy = 0;
  for (std::uint64_t seed = 1; seed <= (smoke() ? 1 : 6); ++seed) {
    const test::StallResult felt = test::simulate_stall({gesture, stall, 1000, seed});
    const test::StallResult calm = test::simulate_stall({gesture, 0, 1000, seed});
    step = std::max(step, felt.worst_step - calm.worst_step), energy = std::max(energy, felt.energy - calm.energy);
  }
  state.counters["step_beyond_calm_N"] = step;
  state.counters["energy_beyond_calm_mJ"] = 1e3 * energy;
}

}  // namespace

void add_cases() {
  const std::vector<double> rates = smoke() ? std::vector{500.0} : std::vector{500.0, 1000.0, 2000.0, 4000.0};
  for (const double rate : rates)
    for (const Clock& clock : {Clock{rate, 0, 0}, {rate, 1, 0}, {rate, 2, 0}, {rate, 0, 0.5}})
      add(fmt::format("wall/delay of {} ticks, jitter of {:g} %/{:g} Hz", clock.delay, 100 * clock.jitter, rate),
          [=](benchmark::State& state) { wall_case(state, clock); });
  for (const double rate : rates)
    add(fmt::format("first force of a hand at 20 mm per s/{:g} Hz", rate),
        [=](benchmark::State& state) { state.counters["depth_mm"] = first_felt(rate) / kMillimetre; });
  for (const test::StallGesture gesture : test::kStallGestures)
    for (const double stall : smoke() ? std::vector{0.05} : std::vector{0.05, 0.2, 0.5, 1.0, 2.0, 5.0})
      add(fmt::format("carver stalls/{}/{:g} ms", name_of(gesture), stall * 1e3),
          [=](benchmark::State& state) { stall_case(state, gesture, stall); });
}

}  // namespace typodont::bench

// Tests of the energy ledger: whatever the hand does, the wall never returns more energy to the hand than the hand put
// in.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "haptics/coupling/passivity.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using test::HapticBench;

constexpr const char* kWall =
    R"({"voxel_mm": 0.2, "domain_mm": [[-3,-3,-5],[3,3,4]], "solids": [{"tissue": "enamel", "solid": {"halfspace": {"normal": [0,0,1], "offset_mm": 0}}}]})";

struct Ledger {
  double least = 0, own_min = 0, last = 0, strongest = 0;
};

/// Runs a path of heights z(t) for `seconds`, and computes the energies independently. Height: m, of the ball's surface
/// above the wall.
Ledger run(double rate, double stiffness, double damping, bool controller, double seconds,
           const std::function<double(int, double)>& z, double jitter = 0) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 1.0_mm;
  s.stiffness = stiffness;
  s.damping = damping;
  s.passivity = controller;
  s.tick = 1 / rate;
  HapticBench bench(kWall, s);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Ledger ledger;
  dvec3 held(0), last_p(0);
  const int n = static_cast<int>(seconds * rate);
  double t = 0;
  for (int i = 0; i < n; ++i) {
    const dvec3 p(0.1_mm, 0, 0.5_mm + z(i, t));
    if (i > 0) ledger.own_min = std::min(ledger.own_min, ledger.last -= glm::dot(held, p - last_p));
    bench.t = from_seconds(t);
    const ServoTick& tick = bench.tick({p});
    held = tick.f_T_W;
    last_p = p;
    ledger.least = std::min(ledger.least, tick.energy);
    ledger.strongest = std::max(ledger.strongest, glm::length(held));
    t += (1 + jitter * uniform(random)) / rate;
    if (jitter > 0 && uniform(random) > 0.95) t += 1 / rate;  // a tick is lost
  }
  return ledger;
}

TEST(Passivity, TheLedgerNeverFallsBelowOneNanojouleForSmoothHandsAtAnyRateAndStiffness) {
  for (const double rate : {100.0, 450.0, 1000.0, 4000.0}) {
    for (const double stiffness : {300.0, 1000.0, 8000.0}) {
      for (const double damping : {0.0, 8.0}) {
        for (const double amplitude : {0.1_mm, 0.7_mm, 2.0_mm}) {
          for (const double hertz : {0.7, 3.0}) {
            const auto path = [&](int, double t) {
              return 0.3 * amplitude + amplitude * std::cos(2 * kPi * hertz * t);
            };
            const Ledger ledger = run(rate, stiffness, damping, true, 2, path);
            EXPECT_GE(ledger.least, -1e-9)
                << rate << " Hz " << stiffness << " N/m " << damping << " " << amplitude << " " << hertz;
            EXPECT_NEAR(ledger.least, ledger.own_min, 1e-12);
          }
        }
      }
    }
  }
}

TEST(Passivity, ATorqueWithoutForceIsLimitedByTheLedgerToo) {
  // The hand turns in the direction of the torque at 5 rad/s. The ledger already contains the energy that the hand gets
  // in the next tick.
  const dvec3 torque(2e-5, 0, 0), turned(5e-3, 0, 0);
  for (const double energy : {-1e-8, 0.0, 1e-8, 1e-7, 1e-6}) {
    haptics::PassivityState state;
    const double fraction =
        haptics::passive_fraction({}, dvec3(0), dvec3(0), torque, turned, 1e-3, 1e-3, energy, state);
    EXPECT_LE(fraction * glm::dot(torque, turned), std::max(energy, 0.0) + 1e-9) << energy;
    EXPECT_TRUE(energy < 1e-6 || fraction == 1);
  }
}

TEST(Passivity, TheControllerDoesNotReduceASteadyForceAtAnyRateFrom250Hertz) {
  for (const double rate : {250.0, 400.0, 500.0, 700.0, 1000.0, 4000.0, 10000.0}) {
    ServoSettings s;
    s.tool.diameter = s.tool.length = 1.0_mm;
    s.damping = 0;
    s.friction = false;
    s.tick = 1 / rate;
    HapticBench bench(kWall, s);
    double weakest = 1e9;
    for (int i = 0; i < static_cast<int>(rate); ++i) {
      const double t = i / rate;  // into the wall at 2 mm/s for 0.3 s, then along it at 30 mm/s
      const ServoTick& tick =
          bench.tick({{1.5_mm * std::sin(20 * std::max(t - 0.3, 0.0)), 0, 0.6_mm - 2e-3 * std::min(t, 0.3)}});
      if (t > 0.35) weakest = std::min(weakest, tick.f_T_W.z);
    }
    EXPECT_NEAR(weakest, 0.5, 0.5e-4) << rate;
  }
}

TEST(Passivity, TheLedgerStaysAboveItsLimitForAHandOneEncoderCountDeep) {
  for (const double rate : {333.0, 1000.0, 4000.0, 10000.0}) {
    for (const double stiffness : {500.0, 1500.0, 8000.0}) {
      const auto path = [&](int, double t) {
        const double wave = std::sin(2 * kPi * 0.9 * t);
        return 0.055_mm * std::round((0.02_mm - 0.06_mm * wave * wave) / 0.055_mm);
      };
      EXPECT_GE(run(rate, stiffness, 2, true, 2, path, rate < 2000 ? 0.4 : 0).least, -1e-9) << rate << " " << stiffness;
    }
  }
}

/// One of many scripted hands. It enters from one millimetre above. Then it moves smoothly, along straight strokes or
/// in steps of an encoder, at any rate and stiffness, with a regular clock or with an irregular clock that loses ticks.
struct RandomHand {
  double rate, stiffness, jitter;
  std::function<double(int, double)> height;
  std::string what;
};

RandomHand random_hand(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  constexpr double kRates[] = {250, 400, 500, 700, 1000, 2000, 4000, 10000},
                   kStiffness[] = {200, 500, 1000, 3000, 8000};
  RandomHand hand{kRates[random() % 8], kStiffness[random() % 5], random() % 3 == 0 ? 0.5 : 0, {}, {}};
  const double deep = between(0.1, 1.5) * 1e-3, high = 1.0_mm, speed = between(2, 100) * 1e-3, hertz = between(0.5, 5);
  const double rest = between(0.02, 0.4), quantum = random() % 3 == 0 ? 0.055_mm : 0;
  std::function<double(double)> path;
  switch (random() % 3) {
    case 0:
      path = [=](double t) { return (high - deep) / 2 + (high + deep) / 2 * std::cos(2 * kPi * hertz * t); };
      break;
    case 1:  // straight down and up, without rests
      path = [=](double t) {
        const double way = high + deep, at = std::fmod(speed * t, 2 * way);
        return high - std::min(at, 2 * way - at);
      };
      break;
    default:  // straight down and up, with rests
      path = [=](double t) {
        const double stroke = (high + deep) / speed, at = std::fmod(t, 2 * (stroke + rest));
        return high - speed * (at < stroke + rest ? std::min(at, stroke) : std::max(2 * stroke + rest - at, 0.0));
      };
  }
  hand.height = [=](int, double t) { return quantum > 0 ? quantum * std::round(path(t) / quantum) : path(t); };
  hand.what = fmt::format("{} Hz, {} N/m, jitter {}, {} mm deep, {} mm/s, {} Hz, counts of {}", hand.rate,
                          hand.stiffness, hand.jitter, deep * 1e3, speed * 1e3, hertz, quantum);
  return hand;
}

TEST(Passivity, TheLedgerStaysAboveItsLimitFor99PercentOfScriptedHands) {
  int held = 0;
  constexpr int kHands = 300;
  for (unsigned seed = 1; seed <= kHands; ++seed) {
    const RandomHand hand = random_hand(seed);
    const Ledger ledger =
        run(hand.rate, hand.stiffness, seed % 2 ? 2 : 0, true, hand.rate > 3000 ? 0.6 : 1.5, hand.height, hand.jitter);
    held += ledger.least >= -1e-9;
    if (ledger.least < -1e-9) std::printf("%u: %g J, %s\n", seed, ledger.least, hand.what.c_str());
  }
  EXPECT_GE(held, kHands * 99 / 100);
}

TEST(Passivity, TheSameSceneInAnyUnitsGivesTheSameForces) {
  const auto forces = [](double size) {
    ServoSettings s;
    s.tool.diameter = s.tool.length = size * 1.0_mm;
    s.tool.cuts = false;
    s.stiffness = 1000 / size;
    s.damping = 2 / size;
    HapticBench bench(
        fmt::format(
            R"({{"voxel_mm": {}, "band_mm": {}, "solids": [{{"tissue": "enamel", "solid": {{"box": {{"size_mm": [{}, {}, {}]}}}}}}]}})",
            0.1 * size, 1.5 * size, 6 * size, 5 * size, 4 * size),
        s);
    std::vector<dvec3> all;
    for (int i = 0; i < 1500; ++i) {
      const double t = i * 1e-3;
      const dvec3 p(2.2_mm * std::sin(4.4 * t), 1.9_mm * std::sin(3.3 * t), 2.6_mm + 0.6_mm * std::cos(6.9 * t));
      all.push_back(bench.tick({size * p}).f_T_W);
    }
    return all;
  };
  const std::vector<dvec3> here = forces(1);
  for (const double size : {0.13, 0.25, 0.5, 3.0, 4.5}) {
    const std::vector<dvec3> there = forces(size);
    double off = 0, most = 0;
    for (std::size_t i = 0; i < here.size(); ++i)
      off = std::max(off, glm::length(there[i] - here[i])), most = std::max(most, glm::length(here[i]));
    EXPECT_LT(off, 1e-6) << size;
    EXPECT_GT(most, 0.4);
  }
}

TEST(Passivity, AnEnergyDebtOfOneContactDoesNotWeakenTheNext) {
  // The hand moved into tissue while the servo had no patch there, so the hand put in no energy. Then it leaves at a
  // speed that could not be predicted. The energy debt must be as small as the force was.
  constexpr const char* kSlab =
      R"({"voxel_mm": 0.15, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [24, 24, 4]}}}]})";
  int in_deficit = 0;
  for (const double out : {1e-4, 1.5e-4, 3e-4}) {
    for (const double deep : {0.1_mm, 0.3_mm}) {
      HapticBench bench(kSlab, {});
      const double surface = 2.0_mm + bench.settings.tool.radius();
      const dvec3 from(0, 0, surface + 1.5_mm), to(7.0_mm, 0, surface - deep);
      for (int i = 0; i < 10; ++i) bench.tick({from});
      Cut cut;
      for (int i = 1; i <= 80; ++i, bench.t += 1'000'000)
        bench.servo.tick({bench.t, {glm::mix(from, to, i / 80.0)}}, bench.last, cut);
      for (int i = 0; i < 200; ++i) bench.tick({to});
      dvec3 at = to;
      for (; at.z < surface + 1.0_mm; at.z += out) bench.tick({at});
      // After three seconds of small motion outside the tissue, the ledger no longer expects fast motion of this hand.
      for (int i = 0; i < 3000; ++i) bench.tick({at + dvec3(0, 0, 0.2_mm * std::sin(2e-3 * kPi * i))});
      in_deficit += bench.last.energy < -1e-10;
      ASSERT_GT(bench.last.energy, -2e-9);
      for (; at.z > surface - 0.5_mm; at.z -= 4e-6) bench.tick({at});
      for (int i = 0; i < 20; ++i) bench.tick({at});
      EXPECT_NEAR(bench.last.f_T_W.z, 0.5, 0.025) << out << " " << deep << ", " << bench.last.energy << " J";
    }
  }
  EXPECT_GT(in_deficit, 0) << "none left a debt that the credit does not cover";
}

TEST(Passivity, AHandThatDithersAtTheSurfaceGainsNoEnergy) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 1);
  for (const double size : {2e-6, 20e-6, 55e-6}) {
    std::vector<double> z(4000);
    double at = 0.8_mm;
    for (double& v : z) {
      at += size * noise(random) - 0.02 * (at + 0.05_mm);
      v = at;
    }
    const Ledger ledger = run(1000, 2000, 1, true, 4, [&](int i, double) { return z[static_cast<std::size_t>(i)]; });
    EXPECT_GE(ledger.least, -1e-9) << size;
    EXPECT_GE(run(1000, 2000, 1, false, 4, [&](int i, double) { return z[static_cast<std::size_t>(i)]; }).strongest,
              0.01);
  }
}

TEST(Passivity, AnArmWithoutTorqueGetsNoEnergyCreditForRotations) {
  // A long head is turned into the wall about its middle, held still and pulled out. All energy was put in by the
  // rotation.
  const auto drawn_out = [&](bool gives_torque) {
    ServoSettings s;
    s.tool.shape = haptics::HeadShape::kCylinder;
    s.tool.diameter = 1.0_mm, s.tool.length = 4.0_mm;
    s.tool.cuts = false;
    s.friction = false;
    s.damping = 0;
    s.gives_torque = gives_torque;
    HapticBench bench(kWall, s);
    Ledger ledger;
    dvec3 last_p(0);
    double z = 1.2_mm;
    const auto tick = [&](double angle) {
      const dvec3 held = bench.last.f_T_W, p(0, 0, z);
      if (bench.t > 0) ledger.own_min = std::min(ledger.own_min, ledger.last -= glm::dot(held, p - last_p));
      last_p = p;
      ledger.least = std::min(ledger.least, bench.tick({p, {std::cos(angle / 2), 0, std::sin(angle / 2), 0}}).energy);
    };
    for (int i = 0; i <= 500; ++i) tick((90 - 40 * i / 500.0) * kDegree);
    for (int i = 0; i < 700; ++i) z += std::min(4e-6, 2e-8 * i), tick(50.0_deg);
    return ledger;
  };
  const Ledger arm = drawn_out(false);
  EXPECT_GE(arm.least, -1e-9);
  EXPECT_GE(arm.own_min, -1e-9) << "what the hand felt, counted outside";
  EXPECT_LT(drawn_out(true).own_min, -1e-6)
      << "an arm that resisted the turn gives back through force what came by torque";
}

TEST(Passivity, WithoutTheControllerAWallReturnsStiffnessTimesSpeedTimesPeriodTimesDepth) {
  for (const double rate : {500.0, 1000.0, 4000.0}) {
    const double v = 50e-3, depth = 2.0_mm, k = 1000;
    // The hand reaches the wall half-way between two ticks. With this phase, the result equals the mean over all phases
    // exactly.
    const auto path = [&](int i, double) {
      const double way = v / rate, top = 0.5_mm;
      const int down = static_cast<int>(std::round((top + depth) / way));
      return top + way / 2 - way * (i < down ? i : 2 * down - i);
    };
    const Ledger ledger = run(rate, k, 0, false, 2 * (0.5_mm + depth) / v, path);
    const double deepest = -path(static_cast<int>(std::round((0.5_mm + depth) * rate / v)), 0);
    EXPECT_NEAR(-ledger.last / (k * v / rate * deepest), 1, 0.02) << rate;
  }
}

TEST(Passivity, AStiffWallNeedsADampingOfHalfStiffnessTimesPeriod) {
  // A mass of 0.15 kg with a damping of b = 5 N·s/m is pushed against the wall. With the tick's length T, oscillations
  // decay if the stiffness K is below 2 b / T, and grow if it is above (Colgate; Abbott & Okamura 2005). The motion
  // between ticks is integrated exactly, as the theory assumes.
  const auto growth = [](double stiffness, bool controller) {
    ServoSettings s;
    s.tool.diameter = s.tool.length = 1.0_mm;
    s.stiffness = stiffness;
    s.damping = 0;
    s.passivity = controller;
    HapticBench bench(kWall, s);
    const double m = 0.15, b = 5, T = 1e-3, e = std::exp(-b / m * T), push = 2.0;
    double z = 0.5_mm - 0.9 * push / stiffness, v = 0, f = 0;
    double early = 0, late = 0;
    for (double p = 2.0_mm; p > z; p -= 20e-6) f = bench.tick({{0.1_mm, 0, p}}).f_T_W.z;
    for (int i = 0; i < 3000; ++i) {
      const double end = (f - push) / b;
      z += end * T + (v - end) * (1 - e) * m / b;
      v = end + (v - end) * e;
      f = bench.tick({{0.1_mm, 0, z}}).f_T_W.z;
      (i < 300 ? early : late) = i < 300 || i >= 2700 ? std::max(i < 300 ? early : late, std::abs(v)) : late;
    }
    return late / early;
  };
  const double critical = 2 * 5 / 1e-3;
  EXPECT_LT(growth(0.98 * critical, false), 0.95);
  EXPECT_GT(growth(1.02 * critical, false), 1.05);
}

TEST(Passivity, TheForceFiltersOfTheLiteratureGenerateEnergyAndTheControllerStopsIt) {
  const auto filtered = [](haptics::ForceFilter filter, bool controller) {
    ServoSettings s;
    s.tool.diameter = s.tool.length = 1.0_mm;
    s.damping = 0;
    s.passivity = controller;
    s.filter = filter;
    HapticBench bench(kWall, s);
    double least = 0;
    for (int i = -10; i < 200; ++i) {  // 100 mm/s, 2 mm deep and out again (values of the paper's own settings)
      const double z = i < 20 ? -i * 0.1_mm : -2.0_mm + (i - 20) * 0.1_mm;
      least = std::min(least, bench.tick({{0.1_mm, 0, 0.5_mm + std::min(z, 3.0_mm)}}).energy);
    }
    return least;
  };
  const double plain = filtered(haptics::ForceFilter::kNone, false);        // effect of sampling alone: K v T D
  EXPECT_LT(filtered(haptics::ForceFilter::kSlew, false), plain - 0.5e-3);  // Wang 2009
  // the filter that the paper of the vertex-deformation simulator describes
  EXPECT_LT(filtered(haptics::ForceFilter::kStroke, false), plain - 0.02e-3);
  EXPECT_GE(filtered(haptics::ForceFilter::kSlew, true), -1e-9);
  EXPECT_GE(filtered(haptics::ForceFilter::kStroke, true), -1e-9);
}

}  // namespace
}  // namespace typodont

// Tests of laws of soft tissue for any hand: it does not create energy, a repeated run gives the same bits, and its
// force has no steps.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "engine/base/units.h"
#include "tests/support/soft_layer.h"

namespace typodont {
namespace {

using namespace literals;
using test::HapticBench;

/// Returns a smooth random path of the tool's centre around the layer, with presses of up to `depth`.
std::function<dvec3(double)> random_path(std::uint32_t seed, double depth) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  struct Wave {
    dvec3 size, phase;
    double rate;
  };
  std::vector<Wave> waves(4);
  for (Wave& w : waves) {
    w.size = dvec3(0.5_mm, 0.5_mm, 0.5 * depth) * dvec3(uniform(random), uniform(random), uniform(random));
    w.phase = 6.3 * dvec3(uniform(random), uniform(random), uniform(random));
    w.rate = 2 * kPi * (0.3 + 4 * uniform(random) * uniform(random));
  }
  return [=](double t) {
    dvec3 p(0, 0, 0.6_mm - 0.2 * depth);
    for (const Wave& w : waves) p += w.size * glm::sin(w.rate * t + w.phase);
    return p;
  };
}

/// Energy stored in the tissue's springs, J.
double elastic_energy(const haptics::SoftTissue& tissue) {
  const haptics::SoftSurface& surface = tissue.surface();
  const auto v = [&](std::uint32_t point) { return tissue.inward(point) - tissue.cut_depth(point); };
  double energy = 0;
  for (std::uint32_t i = 0; i < surface.points().size(); ++i) {
    const haptics::SoftSurface::Point& at = surface.points()[i];
    energy += surface.law().elastic_modulus * at.area / at.thickness * v(i) * v(i) / 2;
    // A link between two points is visited twice, so half of its energy is added each time.
    for (const haptics::SoftSurface::Link& link : surface.links(i))
      energy += link.tension * std::pow(v(i) - v(link.point), 2) / 4;
  }
  return energy;
}

TEST(SoftServo, NoHandGetsEnergyFromSoftTissue) {
  for (std::uint32_t seed = 1; seed <= 16; ++seed) {
    haptics::Tool tool = test::ball_probe();
    tool.cuts = seed % 2 == 0;
    HapticBench bench(test::kBlockFarBelow, test::soft_settings(tool));
    const auto path = random_path(seed, 1.0_mm);
    double own = 0, least = 0, strongest = 0;
    dvec3 held(0), last = path(0);
    for (int i = 0; i < 3000; ++i) {
      const dvec3 p = path(i * 1e-3);
      own -= glm::dot(held, p - last);
      least = std::min(least, own);
      last = p;
      const ServoTick& tick = bench.tick({p}, seed % 4 == 0 ? 1 : 0);
      EXPECT_GE(tick.energy, -1e-9) << seed;
      held = tick.f_T_W;
      strongest = std::max(strongest, glm::length(held));
    }
    if (seed % 4 != 0) {  // the spindle's own work is counted separately
      EXPECT_GE(least, -1e-9) << seed;
    }
    EXPECT_GT(strongest, 0.05) << seed;
  }
}

TEST(SoftTissue, HoldsOnlyEnergyThatTheToolPutIn) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const std::vector<haptics::Tool> tools{test::ball_probe()};
    haptics::SoftTissue tissue(test::flat_layer(), tools, 1000);
    const auto path = random_path(seed, 1.0_mm);
    double given = 0;  // J, work of the tool on the layer
    dvec3 last(0), force(0);
    for (int i = 0; i < 2000; ++i) {
      // the path begins above the layer
      const dvec3 base = path(i * 1e-3) + dvec3(0, 0, std::max(0.0, 3.0_mm - 10e-6 * i));
      const auto out = tissue.tick({i * Nanos(1'000'000), 1e-3, {base}, 0, 0});
      const dvec3 at = base + out.yielded;
      if (i > 0) given -= glm::dot((out.force + force) / 2.0, at - last);
      last = at, force = out.force;
      // The layer's elastic energy must not exceed the work that was put in, except for the error of sums over finite
      // ticks.
      ASSERT_LE(elastic_energy(tissue), given * 1.1 + 3e-6) << seed << " " << i;
    }
  }
}

TEST(SoftServo, TheForceHasNoStepsAtAConstantPushOrASlowSlide) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    HapticBench bench(test::kBlockFarBelow, test::soft_settings(test::ball_probe(1.0_mm)));
    const dvec3 aside(uniform(random), uniform(random), 0);
    double z = 0.8_mm;
    double strongest = 0;
    for (int i = 0; i < 4000; ++i) {
      // Moves down at 2 mm/s to a depth of 0.5 mm, pauses, slides at 1 mm/s, and pauses.
      z = std::max(0.0, z - (i < 1500 ? 2e-6 : 0.0));
      const double slide = 1e-6 * std::clamp(i - 2000, 0, 1500);
      const ServoTick& tick = bench.tick({dvec3(0, 0, z) + slide * aside});
      if (i <= 600) bench.max_step = 0;
      strongest = std::max(strongest, glm::length(tick.f_T_W));
    }
    EXPECT_LT(bench.max_step, 0.02) << seed;
    EXPECT_GT(strongest, 0.1) << seed;
  }
}

}  // namespace
}  // namespace typodont

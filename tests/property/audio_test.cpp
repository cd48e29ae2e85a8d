// Tests of laws that hold for every tested model, order, path and seed.
#include <gtest/gtest.h>

#include "audio/ar/estimate.h"
#include "audio/ar/levinson.h"
#include "audio/ar/spectrum.h"
#include "audio/drill_synth.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

std::vector<double> random_sound(std::mt19937& random, std::size_t count) {
  // Returns a random mixture of noise, tones, steps and jumps, which no model explains.
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<double> x(count);
  const double noise = std::pow(10, -4 * u(random)), tone = u(random), frequency = 3 * u(random), step = u(random);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = noise * normal(random) + tone * std::sin(frequency * static_cast<double>(i)) + (i > count / 2 ? step : 0) +
           (u(random) < 0.001 ? 3.0 : 0.0);
  }
  return x;
}

TEST(EveryFit, HasReflectionCoefficientsInsideTheUnitInterval) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const std::size_t order = 1 + random() % 80;
    const auto x = random_sound(random, 12 * order + 20);
    const auto window = window_samples(Window::kHann, x.size());
    for (const auto& estimate : {burg(x, order), burg(x, order, window), yule_walker(x, order),
                                 yule_walker(x, order, window), modified_covariance(x, order)}) {
      ASSERT_EQ(estimate.reflection.size(), order);
      for (const double k : estimate.reflection) ASSERT_LT(std::abs(k), 1);
      ASSERT_GE(estimate.variance, 0);
    }
  }
}

TEST(EveryFit, IsIndependentOfTheLevelOfTheRecording) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 10; ++trial) {
    auto x = random_sound(random, 2000);
    const auto a = burg(x, 20);
    for (double& v : x) v *= 0.125;
    const auto b = burg(x, 20);
    EXPECT_EQ(a.reflection, b.reflection);
    EXPECT_DOUBLE_EQ(a.variance, 64 * b.variance);
  }
}

TEST(EveryBlend, OfTheReflectionCoefficientsOfTwoStableModelsIsStable) {
  std::mt19937 random(4);
  int unstable_by_predictor = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::uniform_real_distribution<double> k(-0.98, 0.98);
    std::vector<double> a(40), b(40), half(40);
    for (std::size_t i = 0; i < 40; ++i) {
      a[i] = k(random);
      b[i] = k(random);
      half[i] = 0.5 * (a[i] + b[i]);
      EXPECT_LT(std::abs(half[i]), 1);
    }
    const auto pa = step_up(a), pb = step_up(b);
    std::vector<double> between(40);
    for (std::size_t i = 0; i < 40; ++i) between[i] = 0.5 * (pa[i] + pb[i]);
    for (const double v : step_down(between)) {
      if (std::abs(v) >= 1) {
        ++unstable_by_predictor;
        break;
      }
    }
    LatticeFilter lattice(model_of(half));
    double y = 0;
    for (const double e : white(2000, static_cast<std::uint64_t>(trial))) y = lattice.next(e);
    EXPECT_TRUE(std::isfinite(y));
  }
  // unstable blends are the reason why the program never blends the predictor's own coefficients
  EXPECT_GT(unstable_by_predictor, 150);
}

TEST(EveryPath, OfTheLatticeCoefficientsCreatesNoEnergy) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> k(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    const std::size_t order = 1 + random() % 60;
    LatticeFilter lattice(model_of(std::vector<double>(order, 0.0)));
    std::vector<double> reflection(order);
    double energy_in = 0;
    for (const double e : white(3000, static_cast<std::uint64_t>(trial))) {
      for (double& v : reflection) {  // random values for every sample, in half of the runs up to the very edge
        v = trial % 2 ? k(random) : std::copysign(1 - std::pow(10, -1 - 8 * std::abs(k(random))), k(random));
      }
      lattice.set(reflection, 1);
      const double before = lattice.energy();
      lattice.next(e);
      energy_in += e * e;
      ASSERT_LE(lattice.energy(), before + e * e + 1e-9);
    }
    EXPECT_LE(lattice.energy(), energy_in);
  }
}

TEST(EveryTrack, GivesTheSameBitsForAnyBufferSizes) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(0, 1);
  for (int trial = 0; trial < 12; ++trial) {
    SoundModels models;
    models.idle = random_model(random, 2 + random() % 30, 0.7);
    if (trial % 2) models.idle.lines = {{3200.5, 0.03, {{-0.9, 0.1}, 0.02}, {{0.3}, 1.7}}};
    models.free_speed = 1000;
    const double rate = std::array{44100.0, 48000.0, 96000.0}[random() % 3];
    DrillSynth one(models, rate, 5), other(models, rate, 5);
    double t = 0;
    for (int i = 0; i < 200; ++i) {
      SoundState s;
      s.t = from_seconds(t += 0.002 * u(random));
      s.spindle = u(random) < 0.2 ? 0 : 1300 * u(random);
      s.contact_area = u(random) < 0.5 ? 0 : 1e-6 * u(random);
      s.force = u(random);
      s.tissue = static_cast<Tissue>(random() % kTissueCount);
      s.cutting_tool = u(random) < 0.7;
      s.slip_speed = 0.05 * u(random);
      s.suction = u(random) < 0.3;
      one.push(s);
      other.push(s);
    }
    std::vector<float> a(12000), b(12000);
    one.render(a);
    for (std::size_t at = 0; at < b.size();) {
      const auto count = std::min(b.size() - at, static_cast<std::size_t>(1 + random() % 700));
      other.render(std::span<float>(b).subspan(at, count));
      at += count;
    }
    ASSERT_EQ(a, b) << trial;
  }
}

}  // namespace
}  // namespace typodont::audio

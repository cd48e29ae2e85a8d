// Tests the worst input of models and hands for as much sound as a working day has: the sound is finite and bounded and
// has no drift.
#include <gtest/gtest.h>

#include "audio/drill_synth.h"
#include "engine/base/realtime.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

TEST(Stress, RandomModelChangesInEveryBlockKeepTheEnergyBounded) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  LatticeFilter lattice(model_of(std::vector<double>(4, 0.0)));
  GaussianNoise noise(1);
  std::vector<double> reflection(4);
  float e[64];
  double worst = 0;
  for (long block = 0; block < 3600l * 48000 / 64; ++block) {
    // Up to the very edge: |k| → 1.
    for (double& k : reflection) k = std::copysign(1 - std::pow(10, -1 - 8 * std::abs(u(random))), u(random));
    lattice.set(reflection, 1);
    noise.fill(e, 64);
    for (const float v : e) worst = std::max(worst, std::abs(lattice.next(static_cast<double>(v))));
    ASSERT_TRUE(std::isfinite(worst));
  }
  // With noise of variance 1, every state of the filter has a variance of 1 while the coefficients are constant. Jumps
  // of the coefficients can add at most the input of 64 samples.
  EXPECT_LT(worst, 64 * 6.0);
}

TEST(Stress, AFilterOfOrder600AtTheEdgeOfStabilityStaysBounded) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<double> reflection(600);
  LatticeFilter lattice(model_of(std::vector<double>(600, 0.0)));
  GaussianNoise noise(2);
  double energy_in = 0;
  for (int block = 0; block < 300; ++block) {
    for (double& k : reflection) k = std::copysign(1 - std::pow(10, -1 - 11 * std::abs(u(random))), u(random));
    lattice.set(reflection, 1);
    float e[64];
    noise.fill(e, 64);
    for (const float v : e) {
      energy_in += static_cast<double>(v) * static_cast<double>(v);
      ASSERT_TRUE(std::isfinite(lattice.next(static_cast<double>(v))));
    }
    ASSERT_LE(lattice.energy(), energy_in);
  }
}

TEST(Stress, ABillionSamplesOfDecayFromAPoleAt099999EndInSilence) {
  // The envelope is r^n: after 10⁹ samples with r = 0.99999, it has fallen by 86,860 dB. What remains must be exactly
  // zero, and not a small oscillation that never ends.
  flush_denormals();
  const double r = 0.99999, theta = 0.5;
  const ArModel model = resonance(r, theta, 1.0);
  LatticeFilter lattice(model);
  lattice.next(1.0);
  double before = 1e300;
  for (int part = 0; part < 100; ++part) {
    double peak = 0;
    for (int i = 0; i < 10'000'000; ++i) {
      const double y = lattice.next(0.0);
      peak = y > peak ? y : peak;
    }
    ASSERT_LE(peak, std::max(before, 1e-300));  // it never grows again
    if (part == 1) {                            // from sample 10⁷ on: r^n over sin θ
      EXPECT_NEAR(std::log(peak), 1e7 * std::log(r) - std::log(std::sin(theta)), 0.05);
    }
    before = peak;
  }
  EXPECT_LT(before, 1e-300);  // the last bits of the smallest numbers there are
}

TEST(Stress, PolesNearTheUnitCircleGiveTheirTheoreticalVariance) {
  const ArModel model = resonance(0.99999, 0.9, 1e-4);
  LatticeFilter lattice(model);
  GaussianNoise noise(3);
  double sum = 0;
  const int blocks = 600000;
  for (int block = 0; block < blocks; ++block) {
    float e[64];
    noise.fill(e, 64);
    for (const float v : e) sum += std::pow(lattice.next(static_cast<double>(v)) / lattice.level(), 2);
  }
  EXPECT_NEAR(sum / (64.0 * blocks), 1.0, 0.25);  // 384 independent spans of 1/(1−r) samples: 3σ is 0.22
}

TEST(Stress, SoundOfATremblingHandStaysFiniteAndWithinFullScale) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(0, 1);
  SoundModels models = load_sound_models("assets/sounds/micromotor.json");
  DrillSynth synth(models, 48000, 1);
  std::vector<float> y(480);
  double first = 0, last = 0;
  for (int i = 0; i < 60000; ++i) {
    SoundState s;
    s.t = from_seconds(0.01 * i);
    s.spindle = u(random) < 0.1 ? 0 : models.free_speed * 1.5 * u(random);
    s.contact_area = u(random) * 1e-6;
    s.force = 5 * u(random);
    s.removal_rate = u(random) * 2e-9;
    s.tissue = static_cast<Tissue>(random() % kTissueCount);
    s.cutting_tool = u(random) < 0.9;
    s.slip_speed = u(random);
    s.suction = u(random);
    synth.push(s);
    synth.render(y);
    for (const float v : y) ASSERT_LE(std::abs(v), 1.0f);
    (i < 20000 ? first : last) += i < 20000 || i >= 40000 ? power_of_samples(y) : 0;
  }
  EXPECT_NEAR(10 * std::log10(last / first), 0, 0.5);  // no drift
  EXPECT_EQ(synth.late(), 0u);
}

}  // namespace
}  // namespace typodont::audio

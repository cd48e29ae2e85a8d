// Tests the worst input of models and hands over minutes of sound: the sound is finite and bounded and has no drift.
#include <gtest/gtest.h>

#include "audio/drill_synth.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

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
  for (int i = 0; i < 20000; ++i) {
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
    (i < 7000 ? first : last) += i < 7000 || i >= 13000 ? power_of_samples(y) : 0;
  }
  EXPECT_NEAR(10 * std::log10(last / first), 0, 0.5);  // no drift
  EXPECT_EQ(synth.late(), 0u);
}

}  // namespace
}  // namespace typodont::audio

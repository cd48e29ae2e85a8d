// Tests sounds that must not change without notice.
#include <gtest/gtest.h>

#include <cstring>

#include "audio/ar/spectrum.h"
#include "audio/drill_synth.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

// The noise uses only integer arithmetic, square roots and polynomials, so its bits are the same on every machine.
TEST(GoldenNoise, NoiseOfSeedOneIsTheSameOnEveryMachine) {
  const auto x = white(64, 1);
  std::uint64_t hash = 1469598103934665603u;  // FNV-1a over the bits
  for (const double v : x) {
    const auto narrow = static_cast<float>(v);
    std::uint32_t bits;
    static_assert(sizeof bits == sizeof narrow);
    std::memcpy(&bits, &narrow, sizeof bits);
    hash = (hash ^ bits) * 1099511628211u;
  }
  EXPECT_EQ(hash, 9250392052634277921u);
}

// Compares the levels of eight frequency bands, in dB relative to full scale: once for the drill running free, once at
// work in enamel. The models come from Fourier transforms, whose last bits differ between processors. The tolerance is
// half a decibel, a difference that nobody can hear.
TEST(GoldenVoice, TheMicromotorKeepsItsBandLevels) {
  const auto models = load_sound_models("assets/sounds/micromotor.json");
  DrillSynth synth(models, 48000, 1);
  SoundState free, work;
  free.spindle = models.free_speed;
  work = free;
  work.t = from_seconds(4);
  work.spindle *= 0.85;
  work.contact_area = 0.8e-6;
  work.force = 1.5;
  work.removal_rate = 0.3e-9;
  work.tissue = Tissue::kEnamel;
  synth.push(free);
  synth.push(work);
  std::vector<float> y(8 * 48000);
  synth.render(y);
  const double expected[2][8] = {{-35.7, -29.1, -34.4, -31.4, -39.3, -45.8, -44.4, -54.4},
                                 {-27.8, -28.8, -22.3, -24.3, -32.9, -33.1, -44.0, -51.3}};
  for (std::size_t half = 0; half < 2; ++half) {
    const std::vector<double> x(y.begin() + static_cast<std::ptrdiff_t>(half * 4 * 48000 + 2400),
                                y.begin() + static_cast<std::ptrdiff_t>((half + 1) * 4 * 48000));
    const auto power = welch(x, 1024, 48000);
    for (std::size_t band = 0; band < 8; ++band) {
      double sum = 0;
      for (std::size_t i = 43 * band + 1; i <= 43 * (band + 1); ++i) sum += power[i] * 46.875;  // 2 kHz each
      EXPECT_NEAR(10 * std::log10(sum), expected[half][band], 0.5) << half << " " << band;
    }
  }
}

}  // namespace
}  // namespace typodont::audio

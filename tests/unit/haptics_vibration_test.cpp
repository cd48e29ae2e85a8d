// Tests the spindle's vibration in the hand: it has the right frequency and the right strength for the load, stays
// within the device's frequency band, and is off for a device without a band.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "engine/base/units.h"
#include "haptics/coupling/vibration.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::ServoSettings;
using haptics::VibrationLaw;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [5,5,5]}}}]})";

ServoSettings handpiece(double krpm, double band) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 1.2_mm;
  s.spindle.free_speed = krpm * kKrpm;
  s.vibration.band = band;
  return s;
}

/// Amplitude, N, of one component of the force at a frequency, by its Fourier sum over whole seconds.
double amplitude_at(const std::vector<double>& f, double frequency, double rate) {
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    sum += f[i] * std::polar(1.0, -2 * kPi * frequency * static_cast<double>(i) / rate);
  }
  return 2 * std::abs(sum) / static_cast<double>(f.size());
}

/// A hand at a fixed position presses a rotating bur. Returns the force along the push for one second, after the first
/// half second.
std::vector<double> pressed(const ServoSettings& settings, double depth, double pedal = 1) {
  HapticBench bench(kBlock, settings);
  std::vector<double> f;
  for (int i = 0; i < 1500; ++i) {
    const ServoTick& tick = bench.tick({{0, 0, 2.5_mm + 0.6_mm - depth}}, pedal);
    if (i >= 500) f.push_back(tick.f_T_W.z);
  }
  return f;
}

/// A simulated hand (0.15 kg, 5 N·s/m) pushes a rotating bur down. Returns the force along the push in the last half
/// second.
std::vector<double> pushed(const ServoSettings& settings, double newton) {
  HapticBench bench(kBlock, settings);
  double z = 3.12_mm, v = 0, f = 0;
  std::vector<double> forces;
  for (int i = 0; i < 1000; ++i) {
    v += 1e-3 * (f - newton - 5 * v) / 0.15;
    z += 1e-3 * v;
    f = bench.tick({{0, 0, z}}, 1).f_T_W.z;
    if (i >= 500) forces.push_back(f);
  }
  return forces;
}

TEST(Vibration, IsFeltAtTheSpindlesFrequencyAndInProportionToItsLoad) {
  ServoSettings settings = handpiece(6, 200);  // 100 turns a second
  settings.vibration.rotor_mass = 0;           // the cut's part alone, once a turn
  settings.vibration.teeth = 0;
  const auto one = pushed(settings, 1), two = pushed(settings, 2);
  const double once = amplitude_at(one, 100, 1000), twice = amplitude_at(two, 100, 1000);
  EXPECT_GT(once, 0.02);
  EXPECT_NEAR(twice / once, 2, 0.3);
  for (const double aside : {60.0, 80.0, 120.0, 140.0}) EXPECT_LT(amplitude_at(one, aside, 1000), 0.2 * once) << aside;
  EXPECT_LT(amplitude_at(pushed(handpiece(6, 0), 1), 100, 1000), 0.1 * once);  // a device without a band
}

TEST(Vibration, ADrillAboveTheBandIsNotAliasedIntoIt) {
  // 300 krpm is 5 kHz. With ticks at 1 kHz, aliasing could give any frequency.
  const auto with = pressed(handpiece(300, 400), 0.05_mm), without = pressed(handpiece(300, 0), 0.05_mm);
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_EQ(with[i], without[i]) << i;  // bit for bit
}

TEST(Vibration, EveryVibrationPeriodHasAtLeastFiveTicks) {
  // 300 turns per second in a servo of 1 kHz. A device with a band up to 2 kHz feels nothing; with a servo of 4 kHz it
  // feels the vibration.
  ServoSettings slow = handpiece(18, 2000);
  EXPECT_EQ(pressed(slow, 0), pressed(handpiece(18, 0), 0));
  ServoSettings fast = handpiece(18, 2000);
  fast.tick = 1 / 4000.0;
  HapticBench bench(kBlock, fast);
  double most = 0;
  for (int i = 0; i < 400; ++i) most = std::max(most, glm::length(bench.tick({{0, 0, 5.0_mm}}, 1).f_T_W));
  EXPECT_GT(most, 0.01);
}

TEST(Vibration, FreeRunningItIsTheUnbalanceForceAndZeroAtRest) {
  ServoSettings settings = handpiece(6, 200);
  HapticBench bench(kBlock, settings);
  const double omega = settings.spindle.free_speed;
  for (int i = 0; i < 200; ++i) {
    const ServoTick& tick = bench.tick({{0, 0, 5.0_mm}}, 1);  // in the open
    EXPECT_NEAR(glm::length(tick.f_T_W), settings.vibration.rotor_mass * settings.vibration.balance * omega, 1e-9);
    EXPECT_NEAR(tick.f_T_W.z, 0, 1e-12);  // across the shank
  }
  EXPECT_EQ(glm::length(bench.tick({{0, 0, 5.0_mm}}, 0).f_T_W), 0);
}

TEST(Vibration, ItsEnergyDoesNotCountInTheContactLedger) {
  ServoSettings shaking = handpiece(6, 200), still = handpiece(6, 0);
  shaking.cutting = still.cutting = false;  // the same contact in both
  HapticBench a(kBlock, shaking), b(kBlock, still);
  double gave = 0;
  dvec3 last(0), before(0, 0, 3.0_mm);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 p(0.3_mm * std::sin(0.02 * i), 0.2_mm * std::cos(0.05 * i), 2.9_mm + 0.3_mm * std::sin(0.013 * i));
    const ServoTick& with = a.tick({p}, 1);
    const ServoTick& without = b.tick({p}, 1);
    ASSERT_EQ(with.energy, without.energy);
    gave += glm::dot(last, p - before);
    last = with.f_T_W - without.f_T_W;
    before = p;
    ASSERT_NEAR(with.spindle_energy, gave, 1e-12);
  }
}

TEST(Vibration, ComponentsFadeInAndOutAsTheSpindleRunsThroughTheBand) {
  EXPECT_EQ(haptics::band_weight(0, 200), 1);
  EXPECT_EQ(haptics::band_weight(160, 200), 1);
  EXPECT_EQ(haptics::band_weight(200, 200), 0);
  EXPECT_EQ(haptics::band_weight(100, 0), 0);
  double last = 1;
  for (double f = 0; f < 250; f += 0.5) {
    const double fraction = haptics::band_weight(f, 200);
    EXPECT_LE(fraction, last);
    EXPECT_LT(last - fraction, 0.02);
    last = fraction;
  }
}

}  // namespace
}  // namespace typodont

// Tests the sound at the two ears of a spherical head: the published formulas, and the sound that is computed from
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "audio/binaural.h"
#include "audio/drill_synth.h"
#include "engine/base/units.h"
#include "tests/support/audio_signals.h"
#include "tests/support/no_alloc.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

constexpr double kRate = 48000;
constexpr double kDegree = kPi / 180;

std::vector<float> sine(double frequency, std::size_t count) {
  std::vector<float> x(count);
  for (std::size_t i = 0; i < count; ++i)
    x[i] = static_cast<float>(0.5 * std::sin(2 * kPi * frequency * static_cast<double>(i) / kRate));
  return x;
}

std::vector<float> heard(const std::vector<float>& mono, const EarAngles& angles) {
  Binaural ears(kRate);
  ears.turn(angles);
  std::vector<float> stereo(2 * mono.size());
  ears.render(mono, stereo);
  return stereo;
}

/// Returns the complex amplitude of one channel at a frequency, over a whole number of seconds after the start.
std::complex<double> amplitude(const std::vector<float>& stereo, int channel, double frequency) {
  std::complex<double> sum = 0;
  const std::size_t from = 4800, count = stereo.size() / 2 - from;
  for (std::size_t i = from; i < from + count; ++i) {
    const double turns = frequency * static_cast<double>(i) / kRate;
    sum += static_cast<double>(stereo[2 * i + static_cast<std::size_t>(channel)]) *
           std::polar(1.0, -2 * kPi * (turns - std::floor(turns)));
  }
  return 2.0 * sum / static_cast<double>(count);
}

/// Returns the angles between the two ears' directions and a distant source, which is `azimuth` to the right of
/// straight ahead.
EarAngles at(double azimuth) {
  const double right = std::acos(std::sin(azimuth));
  return {kPi - right, right};
}

TEST(SphericalHead, DelaysByWoodworthsFormula) {
  const double unit = kHeadRadius / kSpeedOfSound;
  for (double degrees = 0; degrees <= 90; degrees += 7.5) {
    const double azimuth = degrees * kDegree;
    const EarAngles angles = at(azimuth);
    EXPECT_NEAR(ear_delay(angles.left) - ear_delay(angles.right), unit * (azimuth + std::sin(azimuth)), 1e-12);
  }
  EXPECT_NEAR(ear_delay(at(kPi / 2).left) - ear_delay(at(kPi / 2).right), 656e-6, 1e-6);  // s, source at the right ear
}

TEST(SphericalHead, ShadowsLikeBrownAndDuda) {
  EXPECT_NEAR(ear_shadow(0), 2, 1e-12);                // 6 dB louder in front of the ear
  EXPECT_NEAR(ear_shadow(150 * kDegree), 0.1, 1e-12);  // the darkest direction
  EXPECT_GT(ear_shadow(kPi), 0.2);                     // the bright spot behind the head
}

TEST(SphericalHead, SeesTheAngleBetweenTheEarsAxisAndTheSource) {
  const dvec3 eyes(0, 0, 0.5), right(1, 0, 0);
  const EarAngles ahead = ear_angles({0, 0, 0}, eyes, right);
  EXPECT_NEAR(ahead.left, kPi / 2, 1e-12);
  EXPECT_NEAR(ahead.right, kPi / 2, 1e-12);
  // The ears lie 9 cm behind the eyes: a source 59 cm to the right of a point 50 cm ahead of the eyes is at 45 degrees.
  EXPECT_NEAR(ear_angles({0.59, 0, 0}, eyes, right).right, 45 * kDegree, 1e-9);
  EXPECT_NEAR(ear_angles({-0.59, 0, 0}, eyes, right).left, 45 * kDegree, 1e-9);
  EXPECT_NEAR(ear_angles({0.59, 0, 0}, eyes, right).left, 135 * kDegree, 1e-9);
  EXPECT_NEAR(ear_angles(eyes, eyes, right).left, kPi / 2, 1e-12) << "inside the head";
}

TEST(Binaural, SoundsWithTheDelayAndTheShadowOfTheFormulas) {
  const double omega0 = kSpeedOfSound / kHeadRadius;
  for (const double degrees : {-90.0, -30.0, 0.0, 20.0, 60.0, 90.0}) {
    const EarAngles angles = at(degrees * kDegree);
    for (const double frequency : {500.0, 2000.0, 6000.0}) {
      const auto y = heard(sine(frequency, 4800 * 5), angles);
      const double angle_of[2] = {angles.left, angles.right};
      for (int e = 0; e < 2; ++e) {
        const double w = 2 * kPi * frequency / (2 * omega0);
        const std::complex<double> shadow =
            std::complex<double>(1, ear_shadow(angle_of[e]) * w) / std::complex<double>(1, w);
        const std::complex<double> found = amplitude(y, e, frequency) / std::complex<double>(0, -0.5);
        EXPECT_NEAR(20 * std::log10(std::abs(found)), 20 * std::log10(std::abs(shadow)), 0.5)
            << degrees << " degrees, " << frequency << " Hz, ear " << e;
      }
      if (frequency > 600) continue;  // the delay is unambiguous
      const double delay_l = -std::arg(amplitude(y, 0, frequency)), delay_r = -std::arg(amplitude(y, 1, frequency));
      const auto phase = [&](double angle) {
        const double w = 2 * kPi * frequency / (2 * omega0);
        return -std::arg(std::complex<double>(1, ear_shadow(angle) * w) / std::complex<double>(1, w)) +
               2 * kPi * frequency * ear_delay(angle);
      };
      const double away = delay_l - delay_r - phase(angles.left) + phase(angles.right);
      EXPECT_NEAR(std::remainder(away, 2 * kPi), 0, 0.01) << degrees;
    }
  }
}

TEST(Binaural, MovesWithoutClicks) {
  // The source jumps from one ear to the other every 0.1 s. Between two samples, a channel may not change faster than
  // the sine itself can, including the change of the delay and the shadow's gain of 2.
  Binaural ears(kRate);
  const double frequency = 1000;
  const auto x = sine(frequency, 48000);
  std::vector<float> y(2 * x.size());
  for (std::size_t i = 0; i < x.size(); i += 480) {
    ears.turn(at((i / 4800 % 2 == 0 ? 90 : -90) * kDegree));
    ears.render(std::span(x).subspan(i, 480), std::span(y).subspan(2 * i, 960));
  }
  const double steepest = 2 * 0.5 * 2 * kPi * frequency / kRate;
  for (std::size_t i = 2; i < y.size(); ++i) ASSERT_LT(std::abs(y[i] - y[i - 2]), 1.2 * steepest) << i;
}

TEST(Binaural, GivesTheSameBitsForAnyBufferSizes) {
  const auto x = sine(3100, 4800);
  std::vector<float> whole(2 * x.size()), parts(2 * x.size());
  Binaural a(kRate), b(kRate);
  a.turn(at(0.7));
  b.turn(at(0.7));
  a.render(x, whole);
  for (std::size_t i = 0; i < x.size(); i += 37) {
    const std::size_t count = std::min<std::size_t>(37, x.size() - i);
    b.render(std::span(x).subspan(i, count), std::span(parts).subspan(2 * i, 2 * count));
  }
  EXPECT_EQ(whole, parts);
}

TEST(Binaural, NeverAllocatesWhileItSounds) {
  const auto x = sine(3100, 480);
  std::vector<float> y(2 * x.size());
  Binaural ears(kRate);
  const NoAlloc guard;
  ears.turn(at(1));
  ears.render(x, y);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace typodont::audio

#include <gtest/gtest.h>

#include "audio/ar/levinson.h"
#include "audio/ar/resample.h"
#include "audio/ar/spectrum.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

TEST(Levinson, RecoversTheReflectionCoefficientsOfAModelsSpectrum) {
  std::mt19937 random(2);
  const ArModel model = random_model(random, 24, 0.7);
  double gain = 0;
  const auto k = reflection_of_power(sampled_power(model.reflection, model.gain, 16385), 24, gain);
  for (std::size_t i = 0; i < k.size(); ++i) EXPECT_NEAR(k[i], model.reflection[i], 1e-9);
  EXPECT_NEAR(gain, model.gain, 1e-9);
}

// Impulse response of a pair of poles at r e^±jθ: h[n] = r^n sin((n+1)θ)/sin θ.
double resonance_response(double r, double theta, int n) {
  return std::pow(r, n) * std::sin((n + 1) * theta) / std::sin(theta);
}

TEST(Filters, HaveTheImpulseResponseOfAPolePair) {
  const double r = 0.98, theta = 0.4;
  const ArModel model = resonance(r, theta, 1.0);
  std::vector<double> impulse(512, 0.0), direct(512), block(512);
  impulse[0] = 1;
  DirectFilter<double>(model).process(impulse.data(), direct.data(), 512);
  BlockFilter<double> blocks(model);
  for (std::size_t i = 0; i < 512; i += 64) blocks.process(impulse.data() + i, block.data() + i);
  LatticeFilter lattice(model);
  for (int n = 0; n < 512; ++n) {
    const double expected = resonance_response(r, theta, n);
    const auto i = static_cast<std::size_t>(n);
    EXPECT_NEAR(direct[i], expected, 1e-11);
    EXPECT_NEAR(block[i], expected, 1e-11);
    EXPECT_NEAR(lattice.next(impulse[i]), expected, 1e-11);
  }
}

TEST(Filters, AgreeWithin1e5RelativeOnWellConditionedModels) {
  std::mt19937 random(3);
  for (const std::size_t order : {1u, 2u, 7u, 63u, 64u, 65u, 300u}) {
    const ArModel model = random_model(random, order, 0.6);
    ASSERT_LT(direct_form_condition(model), 1e3);
    const auto noise = white(6400, 7);
    const std::vector<float> narrow(noise.begin(), noise.end());
    std::vector<double> direct(6400), block(6400);
    std::vector<float> single(6400);
    DirectFilter<double>(model).process(noise.data(), direct.data(), 6400);
    BlockFilter<double> blocks(model);
    BlockFilter<float> singles(model);
    for (std::size_t i = 0; i < 6400; i += 64) {
      blocks.process(noise.data() + i, block.data() + i);
      singles.process(narrow.data() + i, single.data() + i);
    }
    LatticeFilter lattice(model);
    double in_block = 0, in_single = 0, in_lattice = 0;
    for (std::size_t i = 0; i < 6400; ++i) {
      in_block += std::pow(block[i] - direct[i], 2);
      in_single += std::pow(static_cast<double>(single[i]) - direct[i], 2);
      in_lattice += std::pow(lattice.next(noise[i]) - direct[i], 2);
    }
    const double power = power_of_samples(direct) * 6400;
    EXPECT_LT(std::sqrt(in_block / power), 1e-12) << order;
    EXPECT_LT(std::sqrt(in_lattice / power), 1e-12) << order;
    EXPECT_LT(std::sqrt(in_single / power), 1e-5) << order;
  }
}

TEST(Gate, IllConditionedModelsUseTheLatticeFilter) {
  EXPECT_EQ(ArFilter(resonance(0.9, 1.0)).form(), ArFilter::Form::kFloat);
  // Forty poles lie close together, so the predictor's coefficients become as large as binomial coefficients.
  std::vector<double> a = {1.0};
  for (int i = 0; i < 40; ++i) {
    std::vector<double> next(a.size() + 1, 0.0);
    for (std::size_t j = 0; j < a.size(); ++j) {
      next[j] += a[j];
      next[j + 1] -= 0.6 * a[j];
    }
    a = next;
  }
  const ArModel crowded = model_of(step_down({a.begin() + 1, a.end()}));
  EXPECT_GT(direct_form_condition(crowded), ArFilter::kFloatLimit);
  EXPECT_NE(ArFilter(crowded).form(), ArFilter::Form::kFloat);
  EXPECT_EQ(ArFilter(model_of(std::vector<double>(60, 0.95))).form(), ArFilter::Form::kLattice);
}

TEST(Noise, IsWhiteGaussianOfUnitVariance) {
  const std::size_t n = 1 << 20;
  const auto x = white(n, 11);
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, lag = 0;
  int beyond_three = 0;
  for (std::size_t i = 0; i < n; ++i) {
    m1 += x[i];
    m2 += x[i] * x[i];
    m3 += x[i] * x[i] * x[i];
    m4 += x[i] * x[i] * x[i] * x[i];
    if (i > 0) lag += x[i] * x[i - 1];
    beyond_three += std::abs(x[i]) > 3;
  }
  const double count = static_cast<double>(n), sigma = 1 / std::sqrt(count);
  EXPECT_NEAR(m1 / count, 0, 4 * sigma);
  EXPECT_NEAR(m2 / count, 1, 4 * std::sqrt(2.0) * sigma);
  EXPECT_NEAR(m3 / count, 0, 4 * std::sqrt(15.0) * sigma);
  EXPECT_NEAR(m4 / count, 3, 4 * std::sqrt(96.0) * sigma);
  EXPECT_NEAR(lag / count, 0, 4 * sigma);
  EXPECT_NEAR(beyond_three / count, 0.0026998, 4 * std::sqrt(0.0027) * sigma);
}

TEST(Resampling, KeepsATonesFrequencyLevelAndPhase) {
  for (const auto& [from, to] :
       {std::pair{44100.0, 48000.0}, {48000.0, 44100.0}, {48000.0, 96000.0}, {96000.0, 44100.0}}) {
    std::vector<double> tone(20000);
    for (std::size_t i = 0; i < tone.size(); ++i) tone[i] = std::sin(2 * kPi * 5000 * static_cast<double>(i) / from);
    const auto y = resampled(tone, from, to);
    double worst = 0;
    for (std::size_t i = 400; i + 400 < y.size(); ++i) {
      worst = std::max(worst, std::abs(y[i] - std::sin(2 * kPi * 5000 * static_cast<double>(i) / to)));
    }
    EXPECT_LT(worst, 2e-5) << from << " to " << to;
  }
}

TEST(Resampling, LeavesNothingOfWhatTheLowerRateCannotHold) {
  std::vector<double> tone(20000);
  for (std::size_t i = 0; i < tone.size(); ++i) tone[i] = std::sin(2 * kPi * 30000 * static_cast<double>(i) / 96000);
  const auto y = resampled(tone, 96000, 44100);
  const std::vector<double> middle(y.begin() + 400, y.end() - 400);
  EXPECT_LT(10 * std::log10(power_of_samples(middle)), -100);
}

TEST(Interpolation, ReadsATonesBetweenItsSamplesTo90Decibels) {
  const InterpolationKernels kernels(2);
  std::vector<float> tone(512);
  for (std::size_t i = 0; i < tone.size(); ++i) tone[i] = static_cast<float>(std::sin(0.9 * static_cast<double>(i)));
  for (double offset = 0; offset < 1; offset += 0.0137) {
    EXPECT_NEAR(kernels.read(tone.data() + 200, offset, 1), std::sin(0.9 * (200 + offset)), 1e-4);
  }
}

TEST(Spectrum, OfAModelSeenThroughTheWindowIsWhatWelchMeasures) {
  const ArModel model = resonance(0.99, 1.0);  // its peak is narrower than the window of 256
  const auto measured = welch(sound_of(model, 1000000, 4), 256, 48000);
  const auto expected = expected_welch(sampled_power(model.reflection, model.gain, 16385), 256, 48000);
  double squares = 0;
  for (std::size_t i = 1; i < 128; ++i) squares += std::pow(10 * std::log10(measured[i] / expected[i]), 2);
  EXPECT_LT(std::sqrt(squares / 127), 0.15);
}

TEST(Distances, AreZeroForEqualSpectraAndKnownForAConstantRatio) {
  const std::vector<double> a = {1, 2, 3}, b = {10, 20, 30};
  EXPECT_DOUBLE_EQ(log_spectral_distance(a, a), 0);
  EXPECT_NEAR(log_spectral_distance(a, b), 10, 1e-12);
  EXPECT_NEAR(itakura_saito(a, b), 0.1 - std::log(0.1) - 1, 1e-12);
}

}  // namespace
}  // namespace typodont::audio

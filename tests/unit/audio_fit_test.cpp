#include <gmock/gmock.h>

#include "audio/ar/estimate.h"
#include "audio/ar/levinson.h"
#include "audio/ar/spectrum.h"
#include "audio/ar_fit.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;
using ::testing::HasSubstr;

constexpr std::size_t kLength = 100000;

// Compares with the asymptotic variance of the estimated AR(2) coefficients (Box & Jenkins): var a1 = var a2 = (1 −
// a2²)/n.
void expect_recovery(Estimate (*estimate)(std::span<const double>)) {
  const ArModel truth = resonance(0.9, 0.7);
  const auto a = step_up(truth.reflection);
  const double sigma = std::sqrt((1 - a[1] * a[1]) / kLength);
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto found = step_up(estimate(sound_of(truth, kLength, seed)).reflection);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(found[i], a[i], 3 * sigma) << "seed " << seed;
      squares += std::pow((found[i] - a[i]) / sigma, 2);
    }
  }
  EXPECT_NEAR(squares / 24, 1.0, 0.9);  // and neither better nor worse than theory
}

TEST(EveryEstimate, RecoversReflectionCoefficientsWithinThreeSigma) {
  expect_recovery([](std::span<const double> x) { return burg(x, 2); });
  expect_recovery([](std::span<const double> x) { return yule_walker(x, 2); });
  expect_recovery([](std::span<const double> x) { return modified_covariance(x, 2); });
}

TEST(Burg, KeepsTheSamplesPowerExactly) {
  std::mt19937 random(1);
  const auto x = sound_of(random_model(random, 10), 20000, 3);
  const Estimate estimate = burg(x, 30);
  ArModel model = model_of(estimate.reflection, std::sqrt(estimate.variance));
  EXPECT_NEAR(power_of(model) / power_of_samples(x), 1, 1e-10);
}

TEST(ModifiedCovariance, ThatComesOutUnstableIsReplacedByTheStableModelOfItsSpectrum) {
  // The sound is a growing oscillation of few samples. For such a sound, least squares gives poles outside the unit
  // circle.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.02);
  int replaced = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> x(60);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::pow(1.05, static_cast<double>(i)) * std::sin(0.6 * static_cast<double>(i)) + noise(random);
    }
    const Estimate estimate = modified_covariance(x, 12);
    for (const double k : estimate.reflection) EXPECT_LT(std::abs(k), 1);
    replaced += estimate.refactored;
  }
  EXPECT_GT(replaced, 0);
}

TEST(Criteria, AicAndBicChooseTheOrderOfTheModelThatMadeTheSound) {
  const ArModel truth = model_of({-0.8, 0.5, -0.4, 0.3, 0.35, -0.3});
  const auto x = sound_of(truth, 20000, 7);
  const auto estimate = burg(x, 40);
  EXPECT_EQ(best_order(estimate.by_order, x.size(), Criterion::kBayes), 6u);
  // Akaike's criterion may choose a higher order, but never a lower one.
  const auto akaike = best_order(estimate.by_order, x.size(), Criterion::kAkaike);
  EXPECT_GE(akaike, 6u);
  EXPECT_LE(akaike, 16u);
}

TEST(SufficientOrder, IsTheTrueOneOfAnOvermodelledSound) {
  const ArModel truth = model_of({-0.8, 0.5, -0.4, 0.3, 0.35, -0.3});
  const auto x = sound_of(truth, 20000, 7);
  ArModel model = model_of(burg(x, 60).reflection);
  EXPECT_EQ(sufficient_order(model), 60u);  // nothing said about the samples
  model.samples = x.size();
  EXPECT_EQ(sufficient_order(model), 6u);
}

class Recording : public ::testing::Test {
 protected:
  FitReport fit(const std::vector<double>& x, FitOptions options = {}, double rate = 48000) {
    write_wav(folder_ / "in.wav", x, rate);
    return fit_recording(folder_ / "in.wav", options);
  }
  /// The message of the refusal.
  std::string refusal(const std::vector<double>& x, FitOptions options = {}) {
    return test::refusal([&] { fit(x, options); });
  }
  static FitOptions of_order(const char* order) {
    FitOptions options;
    options.order = order;
    return options;
  }
  Folder folder_;
};

TEST_F(Recording, ThatCannotBeFittedIsRefusedWithTheReason) {
  const auto sound = sound_of(resonance(0.8, 1.0), 48000, 1);
  auto clipped = sound_of(resonance(0.8, 1.0, 0.5), 48000, 1), no_number = sound;
  for (double& v : clipped) v = std::clamp(v, -0.9, 0.9);
  no_number[1234] = std::nan("");
  std::vector<double> tone(48000);
  for (std::size_t i = 0; i < tone.size(); ++i) tone[i] = 0.5 * std::sin(0.3 * static_cast<double>(i));
  FitOptions magic;
  magic.method = "magic";
  for (const double constant : {0.0, 0.3})
    EXPECT_THAT(refusal(std::vector<double>(48000, constant)), HasSubstr("silence"));
  EXPECT_THAT(refusal(clipped, of_order("20")), HasSubstr("clipping"));
  EXPECT_THAT(refusal(tone), HasSubstr("one tone at 22"));
  EXPECT_THAT(refusal(sound_of(resonance(0.8, 1.0), 1000, 1)), HasSubstr("an order of at most 100"));
  EXPECT_THAT(refusal(no_number), HasSubstr("sample 1234"));
  EXPECT_THAT(refusal(sound, magic), HasSubstr("burg, yule-walker or modified-covariance"));
  EXPECT_THAT(refusal(sound, of_order("12.5")), HasSubstr("--order"));
}

TEST_F(Recording, IsTrimmedOfSilenceAtBothEnds) {
  const auto sound = sound_of(resonance(0.8, 1.0), 48000, 1);
  std::vector<double> x(24000, 0.0);
  x.insert(x.end(), sound.begin(), sound.end());
  x.resize(x.size() + 24000, 0.0);
  const auto report = fit(x, of_order("20"));
  EXPECT_NEAR(report.from, 0.5, 0.025);
  EXPECT_NEAR(report.to, 1.5, 0.025);
  FitOptions untrimmed = of_order("20");
  untrimmed.trim = false;
  EXPECT_DOUBLE_EQ(fit(x, untrimmed).to, 2.0);
}

TEST_F(Recording, WithRunUpKeepsOnlyItsSteadyStretchWhenAsked) {
  auto x = sound_of(resonance(0.8, 1.0), 3 * 48000, 1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / 48000;
    x[i] *= t < 1 ? 0.05 + 0.4 * t : t > 2 ? std::max(0.02, 1 - 2 * (t - 2)) : 1.0;
  }
  FitOptions options = of_order("20");
  options.steady = true;
  const auto report = fit(x, options);
  EXPECT_NEAR(report.from, 1.0, 0.11);
  EXPECT_NEAR(report.to, 2.15, 0.12);
}

TEST_F(Recording, MainsHumIsRemovedAndTheOtherSoundIsUnchanged) {
  const auto clean = sound_of(resonance(0.8, 1.0), 4 * 48000, 1);
  auto x = clean;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += 0.1 * std::sin(2 * kPi * 50 * static_cast<double>(i) / 48000);
  const auto report = fit(x, of_order("20"));
  EXPECT_EQ(report.hum, 50);
  EXPECT_NEAR(report.level_dB, 10 * std::log10(power_of_samples(clean)), 0.1);
  EXPECT_EQ(fit(clean, of_order("20")).hum, 0);
}

TEST_F(Recording, FittedAtAnotherRateHasTheSameSpectrumInHertz) {
  std::mt19937 random(9);
  const auto x = sound_of(random_model(random, 12, 0.6), 3 * 48000, 1);
  const auto original = fit(x, of_order("40")).model;
  FitOptions options = of_order("40");
  options.rate = 44100;
  const auto other = fit(x, options).model;
  EXPECT_EQ(other.rate, 44100);
  std::vector<double> frequencies;
  for (double f = 200; f < 18000; f += 100) frequencies.push_back(f);
  const auto a = spectrum_dB(original, frequencies), b = spectrum_dB(other, frequencies);
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += std::pow(a[i] - b[i], 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(a.size())), 0.3);
}

/// Returns the sound of a drill that starts, idles, works twice at 5 dB more, idles and stops.
std::vector<double> session() {
  std::vector<double> x = sound_of(resonance(0.6, 1.0, 0.02), 10 * 48000, 9);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / 48000;
    const bool load = (t > 3 && t < 4.5) || (t > 6 && t < 7);
    x[i] *= t < 1 ? std::pow(10, t - 1) : t > 9 ? std::pow(10, 9 - t) : load ? 1.8 : 1.0;
  }
  return x;
}

TEST_F(Recording, OfASessionIsDividedIntoRunUpIdleLoadAndRunDown) {
  const auto parts = fit(session()).parts;
  const std::vector<std::pair<DrillPart, double>> expected = {
      {DrillPart::kRunUp, 0}, {DrillPart::kIdle, 1}, {DrillPart::kLoad, 3},   {DrillPart::kIdle, 4.5},
      {DrillPart::kLoad, 6},  {DrillPart::kIdle, 7}, {DrillPart::kRunDown, 9}};
  ASSERT_EQ(parts.size(), expected.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].part, expected[i].first) << i;
    EXPECT_NEAR(parts[i].from, expected[i].second, 0.25) << i;
  }
  EXPECT_NEAR(parts[2].level_dB - parts[1].level_dB, 20 * std::log10(1.8), 0.3);
}

TEST_F(Recording, IsFittedInTheLongestPartThatIsAskedFor) {
  FitOptions options;
  options.part = "load";
  const FitReport report = fit(session(), options);
  EXPECT_NEAR(report.from, 3, 0.1);
  EXPECT_NEAR(report.to, 4.5, 0.1);
  options.part = "idle";
  const FitReport idle = fit(session(), options);
  EXPECT_NEAR(idle.to - idle.from, 2, 0.3);
  options.part = "cutting";
  EXPECT_THAT(refusal(session(), options), HasSubstr("run-up, idle, load or run-down"));
  options.part = "load";
  EXPECT_THAT(refusal(sound_of(resonance(0.6, 1.0, 0.02), 3 * 48000, 1), options), HasSubstr("idle 0.00 to 3.00 s"));
}

TEST_F(Recording, ThatIsNotSteadyIsFittedWithAWarning) {
  EXPECT_THAT(fit(session()).model.notes, HasSubstr("not steady: run-up"));
  EXPECT_EQ(fit(sound_of(resonance(0.6, 1.0, 0.02), 3 * 48000, 1)).model.notes, "");
}

/// Returns a whistle with a mean amplitude of 0.05 over noise. Its amplitude varies slowly by the fraction `varies`,
/// and its frequency by `wanders` (Hz).
std::vector<double> whistle(double frequency, double varies, double wanders, std::uint64_t seed) {
  std::vector<double> x = sound_of(resonance(0.6, 1.0, 0.004), 6 * 48000, seed);
  const double slow = 0.999;  // about 8 Hz: faster than a drift
  const auto amplitude = sound_of(model_of({-slow}, std::sqrt(1 - slow * slow)), x.size(), seed + 1);
  const auto deviation = sound_of(model_of({-slow}, std::sqrt(1 - slow * slow)), x.size(), seed + 2);
  double turns = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    turns += (frequency + wanders * deviation[i]) / 48000;
    x[i] += 0.05 * (1 + varies * amplitude[i]) * std::sin(2 * kPi * turns);
  }
  return x;
}

TEST_F(Recording, OfAWhistleGivesALineWithItsFrequencyAmplitudeAndVariation) {
  const auto x = whistle(3200, 0.17, 6, 5);
  const FitReport report = fit(x);
  ASSERT_EQ(report.model.lines.size(), 1u);
  const ModelLine& line = report.model.lines[0];
  EXPECT_NEAR(line.frequency, 3200, 3);
  EXPECT_NEAR(line.amplitude, 0.05, 0.003);
  EXPECT_NEAR(line.amplitude_noise.deviation(), 0.17, 0.03);
  EXPECT_NEAR(line.frequency_noise.deviation(), 6, 1.5);
  EXPECT_LT(report.distance_dB, 0.6);
  EXPECT_NEAR(10 * std::log10(power_of(report.model)), report.level_dB, 0.2);
}

TEST_F(Recording, OfANarrowBandOfNoiseGivesNoLine) {
  auto x = sound_of(resonance(0.999, 0.42, 0.0005), 6 * 48000, 3);
  const auto hiss = sound_of(resonance(0.6, 1.0, 0.002), x.size(), 4);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += hiss[i];
  EXPECT_TRUE(fit(x).model.lines.empty());
}

TEST_F(Recording, TheRotorsSpeedIsFoundFromItsHarmonicsAlsoIfSomeAreMissing) {
  struct Series {
    double fundamental, noise;  // fundamental frequency, Hz; gain of the noise
    std::vector<int> harmonics;
  };
  for (const auto& [fundamental, noise, harmonics] :
       {Series{1100, 0.02, {1, 2, 3, 4, 5}}, Series{1600, 0.004, {1, 3}}}) {
    auto x = sound_of(resonance(0.6, 1.0, noise), 3 * 48000, 1);
    for (std::size_t i = 0; i < x.size(); ++i)
      for (const int h : harmonics)
        x[i] += 0.02 * std::sin(2 * kPi * fundamental * h * static_cast<double>(i) / 48000 + h);
    EXPECT_NEAR(fit(x).model.spindle / kKrpm / (0.06 * fundamental), 1, 0.0107) << fundamental;
  }
  EXPECT_EQ(fit(sound_of(resonance(0.6, 1.0, 0.02), 3 * 48000, 1)).model.spindle, 0);
}

TEST(ShippedModels, AreWhatTheFitterMakesOfTheShippedRecordings) {
  const auto expect_same = [](const char* recording, const char* model, const FitOptions& options) {
    const FitReport report = fit_recording(std::string("assets/sounds/") + recording, options);
    const ArModel& made = report.model;
    EXPECT_LT(report.distance_dB, made.order() < 100 ? 5 : 0.5) << "dB, up to " << report.up_to << " Hz";
    const ArModel shipped = load_model(std::string("assets/sounds/") + model);
    ASSERT_EQ(made.order(), shipped.order());
    for (std::size_t i = 0; i < made.order(); ++i) EXPECT_NEAR(made.reflection[i], shipped.reflection[i], 1e-9);
    EXPECT_NEAR(made.gain, shipped.gain, 1e-9);
    ASSERT_EQ(made.lines.size(), shipped.lines.size());
    for (std::size_t i = 0; i < made.lines.size(); ++i)
      EXPECT_NEAR(made.lines[i].frequency, shipped.lines[i].frequency, 1e-6);
  };
  FitOptions options;
  expect_same("micromotor_steady.wav", "micromotor_ar300.json", options);
  options.order = "24";
  options.lines = false;
  expect_same("micromotor_steady.wav", "hiss_ar24.json", options);
  options.lines = true;
  options.order = "300";
  options.steady = true;
  expect_same("drill_spinup_run_spindown.wav", "handpiece_ar300.json", options);
}

}  // namespace
}  // namespace typodont::audio

// Tests of fitting densities to a force curve (S2, eq. 14).
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "engine/base/units.h"
#include "haptics/material_fit.h"
#include "haptics/packing.h"
#include "haptics/solid.h"
#include "tests/support/folder.h"

namespace typodont::haptics {
namespace {

using namespace literals;

TEST(MaterialFit, OneStepOfEquation14ChangesTheErrorByOneMinusEtaGSumOfSquares) {
  const std::vector<std::pair<int, double>> overlap = {{0, 3e-9}, {2, 1e-9}, {3, 2e-9}};
  constexpr double kGain = 120, kMeasured = 200;
  const double unit = stability_of(overlap, kGain, 1);
  EXPECT_NEAR(unit, kGain * 14.0 / 36, 1e-12);
  for (const double step : {0.2, 1.0, 1.9, 2.0, 2.5}) {
    std::vector<double> rho = {1, 1, 1, 1};
    const double before = kMeasured - adjust_densities(overlap, kGain, step / unit, kMeasured, rho);
    const double after = kMeasured - adjust_densities(overlap, kGain, 0, kMeasured, rho);
    EXPECT_NEAR(after / before, 1 - step, 1e-12);  // converges immediately at step 1 …
    EXPECT_EQ(std::abs(after) > std::abs(before) * (1 + 1e-9), step > 2) << step;  // … and diverges above 2
    EXPECT_EQ(rho[1], 1);  // density of a sphere that the tool does not touch
  }
}

/// A block of bone into which a ball of 20 mm is moved at 0.03 mm/s.
struct Machine {
  TissueVolume tissue{read_solids(Json::parse(
      R"({"voxel_mm": 0.8, "band_mm": 4, "solids": [{"tissue": "cancellous_bone", "solid": {"box": {"size_mm": [24, 24, 12]}}}]})",
      "t"))};
  ServoSettings settings;
  Machine() {
    settings.tool.diameter = settings.tool.length = 20.0_mm;
    settings.spindle.free_speed = 0.3_krpm;
    for (Material& m : settings.materials) m.stiffness = 1000, m.specific_energy = 4e9;
    settings.method = read_contact_method(Json::parse(R"({"packing": {"spheres": 10000}})", "t"));
  }
  std::vector<FeedSample> way(double from_z) const {
    std::vector<FeedSample> samples;
    for (int i = 0; i < 4000; ++i) {
      samples.push_back({i * 0.03, {dvec3(0, 0, from_z - i * 0.9e-6), {1, 0, 0, 0}}, 0});
    }
    return samples;
  }
};

TEST(MaterialFit, HiddenDensitiesAreRecoveredFromANoisyCurveOf200Newtons) {
  Machine machine;
  // a function of depth, that is, layers
  const auto density = [](double z) { return 1.2 + 0.5 * std::sin(z / 1.5e-3); };
  std::vector<FeedSample> samples = machine.way(16.0_mm);
  // The force curve is an integral over the ball's surface in bone, without spheres: a ring at the angle a from the
  // pole removes bone of its depth.
  const double watt = 0.3 * 10.0_mm * 0.3_krpm, speed = 0.03e-3, R = 10.0_mm;  // W per newton, m/s, m
  double most = 0;
  for (FeedSample& sample : samples) {
    const double middle = sample.X_WT.p.z, rim = std::acos(std::min(1.0, (middle - 6.0_mm) / R));
    constexpr int kRings = 400;
    double sum = 0;
    for (int i = 0; i < kRings; ++i) {
      const double angle = rim * (i + 0.5) / kRings;
      sum += density(middle - R * std::cos(angle)) * std::cos(angle) * std::sin(angle) * rim / kRings;
    }
    sample.force = 2 * kPi * R * R * sum * speed * 4e9 / watt;
    most = std::max(most, sample.force);
  }
  ASSERT_GT(most, 60);
  const double scale = 200 / most;  // scales the force to 200 N, as if the motor turned more slowly
  machine.settings.spindle.free_speed /= scale;
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 2.0);
  for (FeedSample& sample : samples) sample.force = sample.force * scale + noise(random);

  const MaterialFit fit = fit_material(machine.tissue, machine.settings, samples, {}, "curve");
  EXPECT_LT(fit.error.back(), 0.9);
  EXPECT_GT(fit.error.front(), 20 * fit.error.back());
  // Compares the fitted densities with the true ones, in layers of one millimetre, where the tool was.
  PackOptions own;
  own.spheres = 10000;
  const SpherePacking fitted = pack_spheres(machine.tissue, own);
  for (double z = 3.2_mm; z < 5.4_mm; z += 1.0_mm) {
    double found = 0, hidden = 0, volume = 0;
    for (std::size_t i = 0; i < fitted.size(); ++i) {
      if (!fit.fitted[i] || std::abs(fitted.center[i].z - z) > 0.5_mm) continue;
      const double v = std::pow(fitted.radius[i], 3);
      found += v * static_cast<double>(fit.hardness[i]), hidden += v * density(fitted.center[i].z), volume += v;
    }
    EXPECT_NEAR(found / volume, hidden / volume, 0.15 * hidden / volume) << z;
  }
}

TEST(MaterialFit, NoPassMakesTheFitWorseOnCurvesThatNoDensitiesGiveExactly) {
  // Forces with steps, drop-outs and strong noise, and a tool that hardly cuts at first.
  Machine machine;
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 1);
  for (const int kind : {0, 1, 2}) {
    std::vector<FeedSample> samples = machine.way(kind == 2 ? 16.4_mm : 16.0_mm);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const double deep = 16.0_mm - samples[k].X_WT.p.z;
      const double cap = deep > 0 ? 9e3 * deep : 0;
      samples[k].force = kind == 0   ? (k / 500 % 2 == 0 ? 0.2 : 2.5) * cap
                         : kind == 1 ? std::max(0.0, cap * (1 + 0.8 * normal(random)))
                                     : (k % 700 < 30 ? 0 : 5 * cap);
    }
    const MaterialFit fit = fit_material(machine.tissue, machine.settings, samples, {}, "curve");
    for (std::size_t i = 1; i < fit.error.size(); ++i) EXPECT_LE(fit.error[i], fit.error[i - 1]) << kind << ", " << i;
    EXPECT_LT(fit.error.back(), 0.5 * fit.error.front()) << kind;
  }
}

TEST(MaterialFit, ACurveWithoutContactAnUnstableStepAndAnotherModelAreRefused) {
  const Machine machine;
  const std::vector<FeedSample> beside = machine.way(60.0_mm);
  std::vector<FeedSample> samples = machine.way(16.0_mm);
  const auto refused = [&](std::span<const FeedSample> curve, const ServoSettings& settings,
                           const FitOptions& options) {
    return test::refusal([&] { fit_material(machine.tissue, settings, curve, options, "curve.csv"); });
  };
  EXPECT_NE(refused(beside, machine.settings, {}).find("touches nothing"), std::string::npos);
  EXPECT_NE(refused(samples, machine.settings, {}).find("no force"), std::string::npos);
  for (FeedSample& sample : samples) sample.force = 100;
  FitOptions wild;
  wild.eta = 1e3;
  EXPECT_NE(refused(samples, machine.settings, wild).find("unstable"), std::string::npos);
  ServoSettings offset = machine.settings;
  offset.method = default_contact_method();
  EXPECT_NE(refused(samples, offset, {}).find("offset"), std::string::npos);
}

}  // namespace
}  // namespace typodont::haptics

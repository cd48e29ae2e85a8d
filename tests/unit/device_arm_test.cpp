#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/devices/arm.h"
#include "haptics/devices/encoder.h"
#include "tests/support/folder.h"

namespace typodont::haptics {
namespace {

const char* const kPresets[] = {"assets/devices/woody.json", "assets/devices/woody_2019.json",
                                "assets/devices/polhem_v3.json"};

TEST(Arm, WoodenHapticsHasItsPublishedHomePosition) {
  const Arm arm = read_arm(kPresets[0]);
  const dvec3 theta = body_angles(arm, arm.home);
  EXPECT_NEAR(theta.x, 0, 1e-3);
  EXPECT_NEAR(theta.y, 0, 1e-3);
  EXPECT_NEAR(theta.z, kPi / 2, 1e-3);
  const dvec3 p = stylus_pose(arm, arm.home).p;
  EXPECT_NEAR(p.x, 0.025, 1e-6);
  EXPECT_NEAR(p.y, 0.000, 1e-6);
  EXPECT_NEAR(p.z, 0.205, 1e-6);
}

TEST(Arm, PolhemInItsInkwellIsCloseToTheBaseAndToTheSide) {
  // The expected angles were computed by hand from the five-bar equations: θ = 120.4°, 124.8°, 238.5°, λ = -30°, ρ = 36
  // mm.
  const Arm arm = read_arm(kPresets[2]);
  const dvec3 theta = body_angles(arm, arm.home);
  EXPECT_NEAR(theta.x / kDegree, 120.4, 0.2);
  EXPECT_NEAR(theta.y / kDegree, 124.8, 0.2);
  EXPECT_NEAR(theta.z / kDegree, 238.5, 0.2);
  const Pose pose = stylus_pose(arm, arm.home);
  EXPECT_NEAR(glm::length(dvec3(pose.p.x + 0.2045, pose.p.y, 0)), 0.036, 2e-3);
  EXPECT_NEAR(pose.p.z, 0.037, 3e-3);
}

TEST(Arm, JacobianIsTheDerivativeOfThePosition) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> spread(-0.5, 0.5);
  for (const char* preset : kPresets) {
    const Arm arm = read_arm(preset);
    const dvec3 middle = arm.linkage == Arm::Linkage::kSerial ? dvec3(0, 0, kPi / 2) : dvec3(0, 1.2, 3.6);
    for (int n = 0; n < 100; ++n) {
      const dvec3 theta = middle + dvec3(spread(random), spread(random), spread(random));
      const glm::dmat3 J = jacobian(arm, theta);
      for (int i = 0; i < 3; ++i) {
        constexpr double h = 1e-5;
        dvec3 a = theta, b = theta;
        a[i] -= h, b[i] += h;
        const dvec3 slope = (stylus_position(arm, b) - stylus_position(arm, a)) / (2 * h);
        EXPECT_LT(glm::length(slope - J[i]), 1e-7) << preset;
      }
    }
  }
}

TEST(Arm, AMeasuredArmStatesItsCalibratedTipAndItsForceActsAtTheCalibratedAngles) {
  Arm arm = read_arm(kPresets[0]);
  ArmGeometry geometry{.upper = 0.206, .fore = 0.244, .origin = {0.221, 0.001, 0.079}};
  geometry.offset = {0.01, -0.02, 0.015, 0.1, 0, 0}, geometry.scale = {1.002, 0.998, 1.001},
  geometry.sag = {0.01, -0.005};
  EXPECT_NE(test::refusal([&] { use_measured(arm, geometry); }).find("encoders of the stylus"), std::string::npos);
  arm.counts[3] = arm.counts[4] = arm.counts[5] = 4096;
  use_measured(arm, geometry);
  const Counts counts{310, -170, 480, 200, -300, 90};
  const dvec3 body = body_angles(arm, counts), stylus = stylus_angles(arm, counts);
  const ArmReading reading{{body.x, body.y, body.z, stylus.x, stylus.y, stylus.z}};
  EXPECT_LT(glm::distance(stylus_pose(arm, counts).p, tip_position(geometry, reading)), 1e-12);
  const dvec3 theta = true_angles(arm, counts);
  EXPECT_NEAR(theta.x, 1.002 * body.x + 0.01, 1e-12);
  EXPECT_LT(glm::distance(stylus_position(arm, theta), typodont::stylus_pose(geometry, reading).p), 1e-12);
}

TEST(Arm, MotorWorkEqualsTheWorkOnTheHand) {
  // The power of the motors must equal the power at the tip (τ·dθ = F·dp) for any signs and ratios of the transmission.
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const char* preset : kPresets) {
    const Arm arm = read_arm(preset);
    for (int n = 0; n < 100; ++n) {
      const dvec3 theta = dvec3(0.1, 0.9, 2.2) + 0.2 * dvec3(normal(random), normal(random), normal(random));
      const dvec3 force = 0.5 * dvec3(normal(random), normal(random), normal(random));
      const dvec3 rate(normal(random), normal(random), normal(random));
      const Currents currents = motor_currents(arm, theta, force, dvec3(0));
      ASSERT_FALSE(currents.clipped);
      double motor_power = 0;
      for (int i = 0; i < 3; ++i) {
        const double motor_speed = arm.sign[static_cast<std::size_t>(i)] * rate[i] / arm.ratio(i);
        motor_power += currents.amperes[i] * arm.torque_constant[i] * motor_speed;
      }
      EXPECT_NEAR(motor_power, glm::dot(force, jacobian(arm, theta) * rate), 1e-9);
    }
  }
}

TEST(Arm, CurrentsAreScaledTogetherSoThatTheForceKeepsItsDirection) {
  const Arm arm = read_arm(kPresets[0]);
  const dvec3 theta = body_angles(arm, arm.home);
  const Currents weak = motor_currents(arm, theta, {0.1, 0.2, -0.1}, dvec3(0));
  const Currents strong = motor_currents(arm, theta, {100, 200, -100}, dvec3(0));
  EXPECT_TRUE(strong.clipped);
  EXPECT_LT(glm::length(glm::normalize(weak.amperes) - glm::normalize(strong.amperes)), 1e-12);
  double worst = 0;
  for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(strong.amperes[i]));
  EXPECT_DOUBLE_EQ(worst, 3.0);
}

TEST(Arm, ACurrentFromInvalidInputIsZero) {
  const Arm arm = read_arm(kPresets[0]);
  const Currents currents = motor_currents(arm, dvec3(0), {std::nan(""), 1, 1}, dvec3(0));
  EXPECT_EQ(currents.amperes, dvec3(0));
}

TEST(Arm, GravityTorqueIsTheSlopeOfThePotentialEnergy) {
  const Arm arm = read_arm(kPresets[0]);
  const auto potential = [&](double B, double C) {  // potential from the heights above the joints
    return 9.81 * (arm.mass_b * arm.center_b * std::cos(B) +
                   arm.mass_c * (arm.geometry.upper * std::cos(B) - arm.center_c * std::cos(C)));
  };
  for (double B = -0.6; B < 0.7; B += 0.3) {
    for (double C = 1; C < 2.2; C += 0.3) {
      constexpr double h = 1e-6;
      const dvec3 tau = gravity_torque(arm, {0.4, B, C});
      EXPECT_NEAR(tau.y, (potential(B + h, C) - potential(B - h, C)) / (2 * h), 1e-7);
      EXPECT_NEAR(tau.z, (potential(B, C + h) - potential(B, C - h)) / (2 * h), 1e-7);
    }
  }
}

TEST(Arm, APresetOutOfRangeIsRefusedByKey) {
  const test::Folder folder;
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = Json::load(kPresets[0]).text();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    write_file_atomically(folder / "preset.json", text);
    return test::refusal([&] { read_arm(folder / "preset.json"); });
  };
  EXPECT_NE(refused("[160,120,120]", "[160,0,120]").find("body_mm"), std::string::npos);
  EXPECT_NE(refused("\"current_limit_A\":3", "\"current_limit_A\":300").find("current_limit_A"), std::string::npos);
  EXPECT_NE(refused("[2000,2000,2000,0,0,0]", "[2000,0,2000,0,0,0]").find("encoder_counts"), std::string::npos);
}

TEST(Encoder, ContinuesAcrossTheOverflowOfSixteenBits) {
  Encoder encoder;
  encoder.read16(32'700, 100, 100);
  encoder.home(0);
  std::int64_t truth = 0;
  for (int i = 0; i < 3000; ++i) {  // more than one turn, and back
    truth += i < 2000 ? 90 : -70;
    EXPECT_EQ(encoder.read16(static_cast<std::int16_t>(32'700 + truth), 100, 100), Encoder::Step::kGood);
    ASSERT_EQ(encoder.value(), truth);
  }
}

TEST(Encoder, OneBrokenReadingIsIgnored) {
  Encoder encoder;
  encoder.read16(10, 100, 100);
  EXPECT_EQ(encoder.read16(20'000, 100, 100), Encoder::Step::kRejected);
  EXPECT_EQ(encoder.value(), 10);
  EXPECT_EQ(encoder.read16(12, 100, 100), Encoder::Step::kGood);
  EXPECT_EQ(encoder.value(), 12);
}

TEST(Encoder, AJumpThatStaysIsASlipUntilHomed) {
  Encoder encoder;
  encoder.read16(10, 100, 100);
  Encoder::Step step{};
  for (int i = 0; i < Encoder::kAcceptedAfter; ++i) {
    step = encoder.read16(static_cast<std::int16_t>(5000 + i), 100, 100);
    EXPECT_EQ(step == Encoder::Step::kSlipped, i + 1 == Encoder::kAcceptedAfter);
  }
  EXPECT_EQ(encoder.read16(5010, 100, 100), Encoder::Step::kSlipped);
  encoder.home(0);
  EXPECT_EQ(encoder.read16(5011, 100, 100), Encoder::Step::kGood);
  EXPECT_EQ(encoder.value(), 1);
}

}  // namespace
}  // namespace typodont::haptics

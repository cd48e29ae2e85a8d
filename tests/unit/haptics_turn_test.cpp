// Tests the proxy's orientation against closed solutions: a lever on an edge, a peg in a bore with little play.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string_view>
#include <vector>

#include "engine/base/units.h"
#include "haptics/coupling/passivity.h"
#include "haptics/servo/nearest_step.h"
#include "haptics/servo/parameters.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using haptics::ActivePlanesOf;
using haptics::NearPlane;
using haptics::PoseStep;
using haptics::ServoSettings;
using test::HapticBench;

constexpr double kRadius = 0.5e-3, kBore = 0.525e-3, kLength = 6e-3, kIn = 4e-3;  // m, of the peg
const dvec3 kAxis(0.013e-3, 0.007e-3, 0);                                         // m, off the voxels' centres

/// Contact models that give planes. In mesh_lod, only a bur touches with its whole head, here one that stands still.
struct HoldingModel {
  const char* name;
  double voxel_mm;
};
constexpr HoldingModel kModels[] = {{"offset", 0.05}, {"offset", 0.1}, {"mesh_lod", 0.1}};

ServoSettings cylinder(double diameter, double length, const char* model = "offset") {
  ServoSettings s = test::probe_settings(model);
  s.tool.shape = haptics::HeadShape::kCylinder;
  s.tool.diameter = diameter;
  s.tool.length = length;
  s.tool.cuts = model == std::string_view("mesh_lod");
  return s;
}

std::string bore(double voxel_mm) {
  return fmt::format(
      R"({{"voxel_mm": {}, "solids": [{{"tissue": "enamel", "solid": {{"difference": [
          {{"box": {{"center_mm": [0.013, 0.007, -3], "size_mm": [4, 4, 6]}}}},
          {{"cylinder": {{"center_mm": [0.013, 0.007, -2.5], "axis": [0, 0, 1], "radius_mm": 0.525, "height_mm": 7}}}}
         ]}}}}]}})",
      voxel_mm);
}

dquat tilted(double angle, const dvec3& axis) {
  return glm::angleAxis(angle, glm::normalize(axis));
}

double tilt_of(const dquat& R) {
  return std::acos(std::min(1.0, std::abs((R * dvec3(0, 0, 1)).z)));
}

/// Depth of the peg's tip below the mouth of the bore, m.
double depth_of(const Pose& X_WG) {
  return kLength / 2 - X_WG.p.z;
}

/// Largest overlap of the peg and the wall of the bore, m.
double overlap(const Pose& X_WG) {
  double worst = -1;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j < 36; ++j) {
      const double a = j * 10 * kDegree;
      const dvec3 p = X_WG * dvec3(kRadius * std::cos(a), kRadius * std::sin(a), kLength * (i / 40.0 - 0.5)) - kAxis;
      if (p.z < 0) worst = std::max(worst, std::hypot(p.x, p.y) - kBore);
    }
  }
  return worst;
}

/// A peg that stands upright in the bore, `kIn` deep.
struct Peg {
  HapticBench bench;
  Pose hand{kAxis + dvec3(0, 0, 0.1e-3 + kLength / 2), dquat(1, 0, 0, 0)};
  static constexpr double kHeight = kLength / 2 - kIn;

  Peg(double voxel_mm, ServoSettings s) : bench(bore(voxel_mm), s) {
    for (; hand.p.z > kHeight; hand.p.z -= 20e-6) bench.tick(hand);
  }
  /// Leads the hand to another pose in 0.4 s.
  void lead(const Pose& to) {
    const Pose from = hand;
    for (int i = 1; i <= 400; ++i) bench.tick(hand = interpolate(from, to, i / 400.0));
  }
};

TEST(NearestStep, LiesOnTheAllowedSideAndThePushesBalanceTheSprings) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto vector = [&](double size) { return size * dvec3(u(random), u(random), u(random)); };
  for (int round = 0; round < 500; ++round) {
    std::vector<NearPlane> planes(1 + static_cast<std::size_t>(round) % 40);
    for (NearPlane& plane : planes) plane = {vector(4e-3), glm::normalize(vector(1)), 20e-6 * (u(random) + 1)};
    haptics::StepPlanes bounds;
    const double lever = 30e-3;
    bounds.set(planes, lever, 1e-6, 5e-6);
    const PoseStep wanted{vector(0.3e-3), vector(0.3e-3)};
    PoseStep step;
    ActivePlanesOf<6> active;
    ASSERT_TRUE(bounds.nearest(wanted, step, active));
    for (const NearPlane& plane : planes) {
      EXPECT_GT(glm::dot(plane.n, step.p + glm::cross(step.r / lever, plane.x)), -plane.gap - 1e-10);
    }
    PoseStep rest = wanted;
    rest -= step;
    for (int i = 0; i < active.count; ++i) {
      EXPECT_GT(active.push[i], 0);
      const NearPlane& plane = planes[static_cast<std::size_t>(active.index[i])];
      rest += active.push[i] * PoseStep{plane.n, glm::cross(plane.x, plane.n) / lever};
    }
    EXPECT_LT(std::sqrt(dot(rest, rest)), 1e-9) << "force and moments of the contacts against both springs";
  }
}

TEST(Turn, AProbeOnAnEdgeFeelsForceTimesLeverAndTurnsByThisMoment) {
  const dquat R = tilted(90 * kDegree, {0, 1, 0});  // the probe lies along x
  for (const double voxel_mm : {0.05, 0.1}) {
    for (const double lever : {2e-3, 10e-3}) {
      const std::string edge = fmt::format(
          R"({{"voxel_mm": {}, "solids": [{{"tissue": "enamel", "solid": {{"box": {{"center_mm": [{}, 0, -2], "size_mm": [4, 4, 4]}}}}}}]}})",
          voxel_mm, lever * 1e3 + 2);
      const ServoSettings s = cylinder(0.6e-3, 2 * lever + 1e-3);
      const double depth = 0.3e-3, k = s.stiffness, k_turn = haptics::TurnParameters::stiffness;
      HapticBench bench(edge, s);
      for (double z = 0.6e-3; z > 0; z -= 4e-6) bench.tick({{0, 0, z}, R});
      for (int i = 0; i < 100; ++i) bench.tick({{0, 0, 0}, R});
      const double force = depth / (1 / k + lever * lever / k_turn);  // springs in series
      EXPECT_NEAR(bench.last.f_T_W.z, force, 1e-3 * force);
      EXPECT_NEAR(-bench.last.tau_T_W.y, force * lever, 0.01 * force * lever);
      const dvec3 twist = haptics::rotation_vector(R, bench.last.X_WG.R);
      EXPECT_NEAR(glm::length(k_turn * twist - bench.last.tau_T_W), 0, 1e-9);

      ServoSettings without = s;
      without.gives_torque = false;
      HapticBench same(edge, without);
      for (double z = 0.6e-3; z > 0; z -= 4e-6) same.tick({{0, 0, z}, R});
      EXPECT_EQ(same.last.X_WG.R, R) << "an arm without torque cannot hold the orientation";
    }
  }
}

/// Tilts and moves a peg in its bore for 2.5 s, and returns its largest overlap with the wall.
double stir(Peg& peg, std::uint32_t& faults) {
  double worst = -1;
  ServoTick& now = peg.bench.last;
  for (int i = 0; i < 2500; ++i) {
    const double t = 2 * kPi * i * 1e-3;
    const dquat R = tilted(5 * kDegree * std::sin(0.7 * t), {1, 0.3, 0}) *
                    tilted(5 * kDegree * std::sin(0.43 * t), {-0.2, 1, 0}) * tilted(0.08 * t, {0, 0, 1});
    const ServoTick before = now;
    peg.bench.tick(peg.hand = {kAxis + dvec3(0.2e-3 * std::sin(0.9 * t), 0.2e-3 * std::sin(0.61 * t),
                                             Peg::kHeight + 0.3e-3 * std::sin(0.37 * t)),
                               R});
    worst = std::max(worst, overlap(now.X_WG));
    faults |= now.faults;
    if (!peg.bench.settings.gives_torque) continue;
    EXPECT_LT(tilt_of(now.X_WG.R), std::atan(2 * (kBore - kRadius) / depth_of(now.X_WG)) + 0.25 * kDegree) << i;
    EXPECT_LT(glm::length(now.f_T_W - before.f_T_W), 0.065) << i;
    EXPECT_LT(glm::length(now.tau_T_W - before.tau_T_W), 6e-3) << i;
    EXPECT_GT(now.energy, -1e-9);
    const dvec3 twist = haptics::rotation_vector(R, now.X_WG.R);
    if (glm::length(twist) < 1e-3) continue;
    EXPECT_GT(glm::dot(now.tau_T_W, twist), 0.98 * glm::length(twist) * glm::length(now.tau_T_W)) << i;
  }
  return worst;
}

TEST(Turn, APegInABoreTiltsByItsPlayOnlyAndDoesNotPassTheWall) {
  for (const auto& [model, voxel_mm] : kModels) {
    SCOPED_TRACE(fmt::format("{}, voxel {} mm", model, voxel_mm));
    std::uint32_t faults = 0;
    ServoSettings s = cylinder(2 * kRadius, kLength, model);
    Peg peg(voxel_mm, s);
    EXPECT_LT(stir(peg, faults), 20e-6);
    EXPECT_EQ(faults, 0u);
    s.gives_torque = false;
    Peg free(voxel_mm, s);
    EXPECT_GT(stir(free, faults), 0.1e-3) << "a proxy with the hand's orientation passes the wall";
  }
}

TEST(Turn, AStillHandThatHoldsAPegTiltedFeelsNoBuzzAndTheTorqueOfItsPlay) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const double voxel_mm : {0.05, 0.1}) {
    Peg peg(voxel_mm, cylinder(2 * kRadius, kLength));
    int restless = 0;
    for (int hand = 0; hand < 24; ++hand) {
      const double angle = 5 * kDegree * u(random);
      const dvec3 axis(u(random), u(random), 0);
      peg.lead({kAxis + dvec3(0.1e-3 * u(random), 0.1e-3 * u(random), Peg::kHeight + 0.2e-3 * u(random)),
                tilted(angle, axis)});
      for (int i = 0; i < 300; ++i) peg.bench.tick(peg.hand);
      double force = 0, torque = 0;
      for (int i = 0; i < 300; ++i) {
        const ServoTick before = peg.bench.last;
        const ServoTick& now = peg.bench.tick(peg.hand);
        force = std::max(force, glm::length(now.f_T_W - before.f_T_W));
        torque = std::max(torque, glm::length(now.tau_T_W - before.tau_T_W));
      }
      EXPECT_LT(force, 0.06);
      EXPECT_LT(torque, 1e-3);
      restless += force > 2e-3 || torque > 1e-4;
      const double play = std::atan(2 * (kBore - kRadius) / depth_of(peg.bench.last.X_WG));
      EXPECT_NEAR(glm::length(peg.bench.last.tau_T_W),
                  haptics::TurnParameters::stiffness * std::max(0.0, std::abs(angle) - play), 3e-3);
    }
    EXPECT_LE(restless, 5) << "of 24 hands";
  }
}

TEST(Turn, FrictionInABoreIsThatOfTwoContactsThatCarryTheTorque) {
  for (const auto& [model, voxel_mm] : kModels) {
    ServoSettings s = cylinder(2 * kRadius, kLength, model);
    s.friction = true;
    for (const double angle : {1.1 * kDegree, 1.2 * kDegree}) {
      Peg peg(voxel_mm, s);
      peg.lead({kAxis + dvec3(0, 0, Peg::kHeight), tilted(angle, {1, 0, 0})});
      for (int i = 0; i < 800; ++i) peg.hand.p.z += 1e-6, peg.bench.tick(peg.hand);
      const ServoTick& now = peg.bench.last;
      // Each contact pushes with torque / depth. Friction acts against the pull, with a coefficient between the dynamic
      // and the static one; the walls' slope acts with the pull.
      const double push = glm::length(now.tau_T_W) / depth_of(now.X_WG);
      const double friction = -now.f_T_W.z + std::tan(tilt_of(now.X_WG.R)) * push;
      EXPECT_GT(friction, 0.95 * 2 * 0.15 * push) << model << ", " << voxel_mm << ", " << angle / kDegree;
      EXPECT_LT(friction, 1.05 * 2 * 0.2 * push) << model << ", " << voxel_mm << ", " << angle / kDegree;
    }
  }
}

TEST(Turn, AnOffsetPullJamsThePegWhereTwoPointContactSaysSo) {
  // A pull P at the distance e from the axis presses both contacts with P e / depth. So the peg jams if
  // 2 μ e / depth > 1 (Whitney 1982), with static friction 0.2.
  const auto moved = [](const HoldingModel& model, double of_limit) {
    ServoSettings s = cylinder(2 * kRadius, kLength, model.name);
    s.friction = true;
    Peg peg(model.voxel_mm, s);
    const double e = of_limit * kIn / (2 * 0.2), pull = 0.3, mass = 0.1, inertia = 5e-5, dt = 1e-3;
    const double play = std::atan(2 * (kBore - kRadius) / kIn), turn = pull * e / haptics::TurnParameters::stiffness;
    peg.lead({peg.hand.p, tilted(play + turn, {1, 0, 0})});
    const double before = peg.bench.last.X_WG.p.z;
    dvec3 v(0), w(0);
    for (int i = 0; i < 1500; ++i) {
      const ServoTick& now = peg.bench.last;
      v += dt / mass * (now.f_T_W + std::min(1.0, i / 500.0) * dvec3(0, 0, pull) - 10.0 * v);
      w += dt / inertia * (now.tau_T_W + dvec3(pull * e, 0, 0) - 0.02 * w);
      peg.hand.p += dt * v;
      const double angle = glm::length(w) * dt;
      if (angle > 0) peg.hand.R = glm::normalize(tilted(angle, w) * peg.hand.R);
      peg.bench.tick(peg.hand);
    }
    return peg.bench.last.X_WG.p.z - before;
  };
  // the friction spring alone yields by 0.3 mm
  for (const HoldingModel& model : kModels) {
    EXPECT_GT(moved(model, 0.6), 1e-3) << model.name << ", " << model.voxel_mm;
    EXPECT_LT(moved(model, 1.4), 0.4e-3) << model.name << ", " << model.voxel_mm;
  }
}

TEST(Turn, RandomHandsInABoreGainNoEnergy) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int hand = 0; hand < 8; ++hand) {
    ServoSettings s = cylinder(2 * kRadius, kLength);
    s.friction = hand % 2 == 0;
    s.damping = hand % 3 == 0 ? 2 : 0;
    Peg peg(0.1, s);
    const dvec3 a(u(random), u(random), u(random)), b(u(random), u(random), 4 * u(random)),
        phase(u(random), u(random), 0);
    for (int i = 0; i < 1200; ++i) {
      const double t = 6e-3 * i;
      const dvec3 turn =
          0.09 * dvec3(a.x * std::sin(t * (2 + phase.x)), a.y * std::sin(1.7 * t), b.z * std::sin(0.8 * t));
      const double angle = glm::length(turn);
      peg.hand.R = angle > 0 ? tilted(angle, turn) : dquat(1, 0, 0, 0);
      peg.hand.p =
          kAxis +
          0.4e-3 * dvec3(b.x * std::sin(1.3 * t), b.y * std::sin(t * (1.5 + phase.y)), a.z * std::sin(0.9 * t)) +
          dvec3(0, 0, Peg::kHeight);
      ASSERT_GT(peg.bench.tick(peg.hand).energy, -1e-9) << hand << ", " << i;
    }
  }
}

}  // namespace
}  // namespace typodont

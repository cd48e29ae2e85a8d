// Tests of the cutting law of Zhao 2020, eq. (2), which sums over tool voxels, of the criteria for entering and leaving
// a bed, and of the virtual coupling.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/units.h"
#include "haptics/contact/implant/axial_motion.h"
#include "haptics/contact/implant/bed_criteria.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "tests/support/implant_bench.h"

namespace typodont::haptics::implant {
namespace {

constexpr double kU = 2e9, kAlpha = 3, kSpeed = 2 * kPi * 10;  // N = 10 turns per second
constexpr double kN = 10;

CuttingWrench sum_over(const ToolVoxels& voxels, const dvec3& along, bool lower_only) {
  CuttingWrench sum;
  for (const ToolVoxel& v : voxels.outer) {
    if (lower_only && v.n.z > 0) continue;
    add_cutting(v, kU, along, kSpeed, kAlpha, sum);
  }
  return sum;
}
ToolVoxels ball(double r) {
  Tool tool;
  tool.diameter = tool.length = 2 * r;
  return make_tool_voxels(tool, r / 20);
}

TEST(ImplantLaw, AHemispherePlungesWithTheForceTorqueAndPowerOfTheClosedForms) {
  const double r = 1.65e-3, v = 1e-3;
  const CuttingWrench sum = sum_over(ball(r), {0, 0, -1}, true);
  EXPECT_NEAR(v * sum.force.z, kU * v * r * kPi / (4 * kAlpha * kN), 0.02 * kU * v * r * kPi / (4 * kAlpha * kN));
  const double torque = kU * v * r * r / (2 * kN);
  EXPECT_NEAR(-v * sum.torque.z, torque, 0.02 * torque);
  EXPECT_NEAR(-v * sum.torque.z * kSpeed, kU * v * kPi * r * r, 0.02 * kU * v * kPi * r * r);
  EXPECT_LT(std::hypot(sum.force.x, sum.force.y), 1e-3 * sum.force.z);
}

TEST(ImplantLaw, ALowerHemisphereDrawnSidewaysHasTheForcesOfTheClosedForms) {
  const double r = 1.65e-3;
  const CuttingWrench sum = sum_over(ball(r), {1, 0, 0}, true);
  const double x = kU * r * kPi / (16 * kAlpha * kN), y = kU * r / (4 * kN), z = kU * r / (2 * kPi * kAlpha * kN);
  EXPECT_NEAR(std::abs(sum.force.z), z, 0.02 * z);
  EXPECT_NEAR(std::abs(sum.force.y), y, 0.02 * y);
  EXPECT_NEAR(-sum.force.x, x, 0.02 * x) << "against the way";
}

TEST(ImplantLaw, AFlatEndPlungesWithUVROverAlphaN) {
  const Tool drill = test::implant_tool("drill", 4.2, 12, test::drill_block(0, 1));
  const ToolVoxels voxels = make_tool_voxels(drill, 0.06e-3);
  CuttingWrench sum;
  for (std::size_t i = 0; i < voxels.ahead; ++i) add_cutting(voxels.outer[i], kU, {0, 0, -1}, kSpeed, kAlpha, sum);
  const double r = 2.1e-3, force = kU * r / (kAlpha * kN), torque = kU * r * r / (2 * kN);
  EXPECT_NEAR(sum.force.z, force, 0.03 * force);
  EXPECT_NEAR(-sum.torque.z, torque, 0.03 * torque);
}

TEST(ImplantLaw, ReversedRotationReversesTheTangentialForce) {
  CuttingWrench there, back;
  for (const ToolVoxel& v : ball(1e-3).outer) {
    add_cutting(v, kU, {0, 0, -1}, kSpeed, kAlpha, there);
    add_cutting(v, kU, {0, 0, -1}, -kSpeed, kAlpha, back);
  }
  EXPECT_DOUBLE_EQ(there.torque.z, -back.torque.z);
  EXPECT_DOUBLE_EQ(there.force.z, back.force.z);
}

TEST(ImplantLaw, TheVoxelsOfA42By12MillimetreToolCoverItsFlankAndEndOnce) {
  const ToolVoxels voxels = make_tool_voxels(test::implant_tool("drill", 4.2, 12, test::drill_block(0, 1)), 0.06e-3);
  double flank = 0, end = 0;
  for (std::size_t i = 0; i < voxels.outer.size(); ++i)
    (i < voxels.ahead ? end : flank) += static_cast<double>(voxels.outer[i].area);
  EXPECT_NEAR(end / (kPi * 2.1e-3 * 2.1e-3), 1, 0.01);
  EXPECT_NEAR(flank / (kPi * 4.2e-3 * 12e-3), 1, 0.02);
}

TEST(ImplantCriteria, AllSixteenCombinationsDecideAsInThePaper) {
  for (const bool can_begin : {false, true}) {
    for (int bits = 0; bits < 16; ++bits) {
      const BedCriteria c{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0};
      const BedDecision expected = !c.pushed                            ? BedDecision::kStayFree
                                   : c.at_centre && c.fits && c.aligned ? BedDecision::kEnterBed
                                   : can_begin                          ? BedDecision::kBeginBed
                                                                        : BedDecision::kStayFree;
      EXPECT_EQ(decide(c, can_begin), expected) << bits << can_begin;
    }
  }
}

TEST(ImplantCoupling, TheLimitOfZeroMassIsTheMasslessCoupling) {
  constexpr double k = 3000, drag = 800, dt = 1e-3;
  AxialState light, none;
  double at_light = 0, at_none = 0, worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const double hand = 1e-3 * std::sin(i * 1e-2);
    at_light += coupled_step(hand - at_light, k, 1e-9, drag, dt, light);
    at_none += coupled_step(hand - at_none, k, 0, drag, dt, none);
    worst = std::max(worst, k * std::abs(at_light - at_none));
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(ImplantCoupling, IsStableForAnyStiffnessAndAnyPeriod) {
  std::mt19937_64 random(28);
  const auto decade = [&](double lo, double hi) {
    return std::pow(10.0, std::uniform_real_distribution<double>(lo, hi)(random));
  };
  for (int i = 0; i < 1000; ++i) {
    const double k = decade(1, 7), dt = decade(-4.5, -1), mass = decade(-4, 0), drag = decade(0, 4);
    AxialState state;
    double at = 0, most = 0;
    for (int n = 0; n < 200000 && std::abs(1e-3 - at) > 1e-9; ++n) {
      at += coupled_step(1e-3 - at, k, mass, drag, dt, state);
      most = std::max(most, std::abs(at));
    }
    // The motion settles within drag/k or mass/drag seconds. In all cases the amplitude of the oscillation must stay
    // limited.
    EXPECT_LE(most, 2.0e-3) << k << " " << dt << " " << mass << " " << drag;
  }
}

TEST(ImplantCoupling, AnObstacleBlocksTheAdvanceButNeverTheRetreat) {
  EXPECT_EQ(allowed_step(1e-4, 0, 1e-4, true, false), 0);
  EXPECT_EQ(allowed_step(-1e-4, 0, 2e-4, true, false), -1e-4);
  EXPECT_EQ(allowed_step(5e-4, 1, 1e-4, false, false), 1e-4) << "no more than a step";
  // Eq. (7) is printed in the paper with the opposite sense. With it, a tool in a finished bed could not move at all.
  EXPECT_EQ(allowed_step(1e-4, 1, 1e-4, false, true), 0);
  EXPECT_EQ(allowed_step(1e-4, 0, 1e-4, true, true), 1e-4);
}

}  // namespace
}  // namespace typodont::haptics::implant

// Tests the whole calibration with the simulated bench: the remaining error is the noise.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "calibration/bench_simulator.h"
#include "calibration/joint_solver.h"

namespace typodont::calibration {
namespace {

/// Calibration of a rigid bench; made once.
const SimulatedRoutine& routine(std::uint64_t seed) {
  static std::map<std::uint64_t, SimulatedRoutine> made;
  const auto found = made.find(seed);
  return found != made.end() ? found->second : made.emplace(seed, simulate_routine({.seed = seed})).first->second;
}

TEST(Routine, LeavesAnErrorOfAtMost50MicrometresWith200MicrometresOfTouchNoise) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SimulatedRoutine& run = routine(seed);
    EXPECT_GT(run.before.rms, 3e-3) << seed;
    // The limits are 0.05 mm rms and 0.15 mm for the worst point. The noise of the measurement adds 0.02 mm.
    EXPECT_LT(run.after.rms, std::hypot(0.05e-3, 0.02e-3)) << seed;
    EXPECT_LT(run.after.worst, std::hypot(0.15e-3, 0.02e-3)) << seed;
    EXPECT_TRUE(run.bench.verification->pass) << seed << run.bench.verification->verdict;
    EXPECT_TRUE(run.bench.registration->trusted()) << seed;
    EXPECT_NEAR(run.bench.delay->delay, 0.0234, 4 * run.bench.delay->sigma) << seed;
  }
}

TEST(Routine, ABentPanelACurvedMirrorASoftArmAndASlippedTipTogetherLeaveAnErrorOfAtMost50MicrometresRms) {
  constexpr int kSoft = 12;
  double squares = 0, worst = 0;
  int bent = 0, curved = 0, slipped = 0, wrong = 0;
  for (std::uint64_t seed = 1; seed <= kSoft; ++seed) {
    wrong += static_cast<int>(routine(seed).bench.joint->terms.size());
    const SimulationOptions options{.seed = seed, .soft = 1};
    const SimulatedRoutine run = simulate_routine(options);
    squares += std::pow(run.after.rms, 2) / kSoft, worst = std::max(worst, run.after.worst);
    const BenchSimulator truth(options);
    for (const JointResult::Term& term : run.bench.joint->terms) {
      bent += term.name == "panel bent", curved += term.name == kMirrorCurved, slipped += term.name.starts_with("tip");
      for (int axis = 0; term.name == kMirrorCurved && axis < 3; ++axis)
        EXPECT_NEAR(term.value[axis], truth.truth().mirror->curvature[axis], 5 * term.sigma[axis]) << seed;
    }
  }
  EXPECT_LT(std::sqrt(squares), 0.05e-3);
  EXPECT_LT(worst, 0.15e-3);
  EXPECT_EQ(bent, kSoft);
  EXPECT_GE(curved, kSoft - 1);
  EXPECT_GE(slipped, 2 * kSoft);  // of three steps; some of the random slips are too small to be seen
  EXPECT_LE(wrong, 1) << "terms that the touches of rigid benches seem to show";
}

TEST(Routine, IsExactWithoutNoise) {
  SimulationOptions options;
  options.touch_noise = 0, options.slipped = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    options.seed = seed;
    options.soft = 0;
    EXPECT_LT(simulate_routine(options).after.worst, 1e-12 * 0.5) << seed;  // m, 1e-12 of the arm's reach
    options.soft = 1;
    EXPECT_LT(simulate_routine(options).after.worst, 1e-8) << seed;
  }
}

TEST(Routine, ErrorFallsWithTheRootOfTheNumberOfTouches) {
  double few = 0, many = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SimulationOptions options;
    options.seed = seed;
    options.touches = 0.5;
    few += std::pow(simulate_routine(options).after.rms, 2);
    options.touches = 2;
    many += std::pow(simulate_routine(options).after.rms, 2);
  }
  EXPECT_NEAR(std::sqrt(few / many), 2, 0.7);
}

glm::dmat3 axes_of(const Panel& panel) {
  const dvec3 right = glm::normalize(panel.lower_right - panel.lower_left),
              normal = glm::normalize(glm::cross(right, panel.upper_left - panel.lower_left));
  return {right, glm::cross(normal, right), normal};
}

TEST(Routine, ErrorsOfTheJointSolutionHaveTheReportedStandardDeviations) {
  constexpr int kBenches = 20,
                kErrors = 4 * kBenches;  // of the user's offset along x, y, z, and of the interpupillary distance
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= kBenches; ++seed) {
    const JointResult& found = *routine(seed).bench.joint;
    const RigGeometry truth = BenchSimulator({.seed = seed}).truth();
    // The solution's frame W is turned from that of the truth, because its base of the arm is an estimate.
    const glm::dmat3 R = axes_of(found.panel) * glm::transpose(axes_of(truth.panel));
    const dvec3 off = (found.user_offset_W - R * SimulationOptions{}.user_offset) / found.user_offset_sigma;
    squares += glm::dot(off, off) + std::pow((found.eyes.ipd - truth.eyes.ipd) / found.ipd_sigma, 2);
  }
  // Mean square of n standard normal errors: 1, with a standard deviation of sqrt(2 / n).
  EXPECT_NEAR(squares / kErrors, 1, 4 * std::sqrt(2.0 / kErrors));
}

TEST(Routine, TheEyePositionsCanBeComputedAgainAfterTheRegistration) {
  // This user sees every point 1.3 mm beside its place. The registration of the base includes this offset, but the
  // alignments use the true position of the tip.
  SimulatedRoutine run = simulate_routine({});
  const dvec3 before = run.bench.rig.eyes.center;
  solve_eyes_step(run.bench, run.captures, true);
  ASSERT_EQ(run.bench.eyes_result->not_determined, "");
  EXPECT_LT(run.bench.eyes_result->rms, 4e-4);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(run.bench.rig.eyes.center[axis], before[axis], 4.5 * run.bench.eyes_result->center_sigma[axis] + 5e-4);
    EXPECT_NEAR(run.bench.eyes_result->user_offset->W[axis], SimulationOptions{}.user_offset[axis], 1e-3);
  }
}

TEST(Arm, InjectedErrorsAreRecoveredWithinTheReportedUncertainty) {
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SimulationOptions options;
    options.seed = seed;
    BenchSimulator simulator(options);
    BenchState bench = simulator.drawings();
    Captures captures;
    simulator.capture_arm(captures, bench);
    solve_arm_step(bench, captures);
    EXPECT_NEAR(bench.arm_result->sigma, 2e-4, 2e-5);
    EXPECT_GT(bench.arm_result->before_rms, 2 * bench.arm_result->after_rms);
    const auto truth = to_vector(simulator.true_arm());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const ArmParameter& p = bench.arm_result->parameters[i];
      if (p.determined < 0.95) continue;
      squares += std::pow((p.after - truth[i]) / p.sigma, 2), ++count;
      EXPECT_LT(std::abs(p.after - truth[i]), 5 * p.sigma) << p.name;
    }
  }
  EXPECT_GT(count, 40);
  EXPECT_NEAR(squares / count, 1, 0.5);
}

TEST(Arm, CapturesOfADifferentArmAreRejected) {
  // The user took the plate of holes for one with another pitch. No arm that is near the drawings explains these
  // positions.
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    BenchSimulator simulator({.seed = seed});
    BenchState bench = simulator.drawings();
    const double drawn = bench.arm.upper;
    Captures captures;
    simulator.capture_arm(captures, bench);
    for (ArmCapture& c : captures.arm) {
      if (c.known) *c.known *= 1.5;
    }
    solve_arm_step(bench, captures);
    EXPECT_NE(bench.arm_result->misfit, "") << seed;
    EXPECT_EQ(bench.arm.upper, drawn) << seed;
  }
}

TEST(Arm, SocketsAloneDoNotDetermineTheScaleOfTheArm) {
  SimulationOptions options;
  BenchSimulator simulator(options);
  BenchState bench = simulator.drawings();
  Captures captures;
  simulator.capture_arm(captures, bench);
  std::erase_if(captures.arm, [](const ArmCapture& c) { return c.known.has_value(); });
  const ArmResult sockets = solve_arm(captures.arm, bench.arm);
  bool named = false;
  for (const std::string& open : sockets.not_observable) {
    named = named || (open.find("link") != std::string::npos && open.find("tip x") != std::string::npos);
  }
  EXPECT_TRUE(named) << "links and tip together are the unknown scale";
}

}  // namespace
}  // namespace typodont::calibration

// A whole mirror bench in the computer: an arm with wrong links, a panel and a mirror that are not where the drawings
// say, a user with eyes of their own and an unsteady hand. The routine runs against it without hardware, and is tested
// so.
#pragma once

#include <cstdint>

#include "calibration/routine.h"
#include "calibration/statistics.h"

namespace typodont::calibration {

struct SimulationOptions {
  std::uint64_t seed = 1;
  double touch_noise = 2e-4;  // m per axis, of every touch
  double slipped = 0.02;      // share of touches that miss by millimetres
  bool arm_errors = true;     // links ±1 mm, joints ±1°, scales ±0.5 %
  double placement_error =
      0.02;  // m and, times ten, rad·0.5: how far panel, mirror, base and eyes are off the drawings
  dvec3 user_offset{0.0004, -0.0003, 0.0012};  // m, felt minus seen
  double delay = 0.0234;                       // s, of the display against the arm
  double touches = 1;                          // multiplies the number of touches of every step
};

class BenchSimulator {
 public:
  explicit BenchSimulator(const SimulationOptions& options);

  const ArmGeometry& true_arm() const { return arm_; }
  const RigGeometry& truth() const { return truth_; }
  /// What the drawings say: where the routine starts.
  BenchState drawings() const;

  /// The encoders when the tip is exactly at p_W, the wrist held somehow.
  ArmReading hold(const dvec3& p_W);
  /// The same with the unsteadiness of a hand.
  Touch touch(const dvec3& p_W, const ArmGeometry& believed_arm);
  /// Where this user reaches for what a program draws at p_W.
  dvec3 reached_for(const RigGeometry& believed, const dvec3& p_W) const;

  // The captures of each step, made with what is believed when its turn comes.
  void capture_arm(Captures& captures, const BenchState& bench);
  void capture_screen(Captures& captures, const BenchState& bench);
  void capture_eyes(Captures& captures, const BenchState& bench);
  void capture_register(Captures& captures, const BenchState& bench);
  void capture_delay(Captures& captures, const BenchState& bench);
  void capture_verify(Captures& captures, const BenchState& bench);

  struct Colocation {
    double rms = 0, worst = 0, mean = 0;  // m
  };
  /// The tool is held somewhere in the workspace, the arm read, the tool drawn: how far from the hand does this user
  /// see it? Over 9×9×9 points of the workspace.
  Colocation colocation(const BenchState& bench);

 private:
  std::size_t many(double count) const;
  SimulationOptions options_;
  Noise random_;
  ArmGeometry arm_;
  RigGeometry truth_;
};

/// Drawings → captures → solved, step by step.
struct SimulatedRoutine {
  Captures captures;
  BenchState bench;
  BenchSimulator::Colocation before, after;
};
SimulatedRoutine simulate_routine(const SimulationOptions& options);

}  // namespace typodont::calibration

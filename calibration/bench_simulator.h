// Simulates a complete mirror bench: an arm with wrong link lengths, a panel and a mirror that deviate from the
// drawings, and a user with individual eyes and an unsteady hand. The simulation runs and tests the calibration routine
// without hardware.
#pragma once

#include <cstdint>

#include "calibration/routine.h"
#include "calibration/statistics.h"

namespace typodont::calibration {

struct SimulationOptions {
  std::uint64_t seed = 1;
  double touch_noise = 2e-4;  // m per axis, standard deviation of the noise of a touched position
  double slipped = 0.02;      // fraction of the touches that miss by millimetres
  bool arm_errors = true;  // true: the arm has link errors of ±1 mm, joint errors of ±1°, and scale errors of ±0.5 %
  // m and rad; range of the random errors in the positions and orientations of panel, mirror, haptic base and eyes,
  // compared with the drawings. The angles of the panel, the base and the eyes have up to twice this error.
  double placement_error = 0.02;
  // m, systematic offset of the user: the position that the user feels minus the position that the user sees
  dvec3 user_offset{0.0004, -0.0003, 0.0012};
  double delay = 0.0234;  // s, delay of the display relative to the arm
  double touches = 1;     // factor by which the number of touches of every step is multiplied
};

class BenchSimulator {
 public:
  explicit BenchSimulator(const SimulationOptions& options);

  const ArmGeometry& true_arm() const { return arm_; }
  const RigGeometry& truth() const { return truth_; }
  /// Returns the nominal bench, which has the dimensions of the drawings. The calibration routine starts with it.
  BenchState drawings() const;

  /// Returns the encoder readings of the arm while its tip is exactly at p_W (m, frame W). The orientation of the wrist
  /// is arbitrary.
  ArmReading hold(const dvec3& p_W);
  /// Simulates a touch at p_W (m, frame W) by an unsteady hand. `believed_arm` is the geometry with which the touch's
  /// position is computed.
  Touch touch(const dvec3& p_W, const ArmGeometry& believed_arm);
  /// Returns the position to which this user moves the tip in order to touch a point that a program draws at p_W.
  dvec3 reached_for(const RigGeometry& believed, const dvec3& p_W) const;

  // Each function capture_…() simulates the captures (recorded touches) of one calibration step. `bench` is the
  // estimate of the bench before this step.
  void capture_arm(Captures& captures, const BenchState& bench);
  void capture_screen(Captures& captures, const BenchState& bench);
  void capture_eyes(Captures& captures, const BenchState& bench);
  void capture_register(Captures& captures, const BenchState& bench);
  void capture_delay(Captures& captures, const BenchState& bench);
  void capture_verify(Captures& captures, const BenchState& bench);

  struct Colocation {
    double rms = 0, worst = 0, mean = 0;  // m, co-location error over all points: root mean square, largest, and mean
  };
  /// Returns the co-location error of the present calibration at 9×9×9 points of the workspace. At each point, the
  /// program reads the arm's pose, and draws the tool where it believes the tool to be. The error is the distance
  /// between the hand's position and the position at which the user sees the drawn tool.
  Colocation colocation(const BenchState& bench);

 private:
  std::size_t many(double count) const;
  SimulationOptions options_;
  Noise random_;
  ArmGeometry arm_;
  RigGeometry truth_;
};

/// Runs the calibration routine step by step, beginning with the nominal bench of the drawings. Each step makes its
/// captures, then solves them.
struct SimulatedRoutine {
  Captures captures;
  BenchState bench;
  BenchSimulator::Colocation before, after;
};
SimulatedRoutine simulate_routine(const SimulationOptions& options);

}  // namespace typodont::calibration

// Simulates a mirror bench with an inaccurate arm, a displaced panel and mirror, and a user with individual eyes and an
// unsteady hand.
#pragma once

#include <cstdint>

#include "calibration/routine.h"
#include "calibration/statistics.h"

namespace typodont::calibration {

struct SimulationOptions {
  std::uint64_t seed = 1;
  double touch_noise = 2e-4;  // m per axis, standard deviation of a touch
  double slipped = 0.02;      // fraction of the touches that miss their target by millimetres
  // 0: a rigid bench. 1: a panel bent by up to 0.6 mm, a mirror that sags by up to 0.5 mm, an arm that bends by up to
  // 0.5°/m, a tip that slips by up to 0.4 mm between the steps.
  double soft = 0;
  bool arm_errors = true;  // true: the arm's parameters have errors of ±1 mm, ±1° and ±0.5 % (scales)
  // Largest displacement per axis (m) and rotation (rad) from the nominal poses; panel, base, eyes: twice the rotation.
  double placement_error = 0.02;
  // Position at which the user feels a point minus position at which the user sees it, m.
  dvec3 user_offset{0.0004, -0.0003, 0.0012};
  double delay = 0.0234;  // s, delay of the display relative to the arm
  double touches = 1;     // factor on the usual number of touches in each step
};

class BenchSimulator {
 public:
  explicit BenchSimulator(const SimulationOptions& options);

  const ArmGeometry& true_arm() const { return arm_; }
  const RigGeometry& truth() const { return truth_; }
  /// The workbench according to its technical drawings: start values of the calibration routine.
  BenchState drawings() const;

  /// Encoder readings of the arm when its tip is at p_W (m); the angles of the wrist are random.
  ArmReading hold(const dvec3& p_W);
  /// A touch at p_W (m) by an unsteady hand. The touch's position is computed with the geometry `believed_arm`.
  Touch touch(const dvec3& p_W, const ArmGeometry& believed_arm);
  /// Position to which this user moves the tip if a point is drawn at p_W.
  dvec3 reached_for(const RigGeometry& believed, const dvec3& p_W) const;

  // Functions that add the captures of one step. `bench`: estimate before the step.
  void capture_arm(Captures& captures, const BenchState& bench);
  void capture_screen(Captures& captures, const BenchState& bench);
  void capture_eyes(Captures& captures, const BenchState& bench);
  void capture_register(Captures& captures, const BenchState& bench);
  void capture_delay(Captures& captures, const BenchState& bench);
  void capture_verify(Captures& captures, const BenchState& bench);

  struct Colocation {
    double rms = 0, worst = 0, mean = 0;  // m, error at the points: distance of the hand from the seen tool
  };
  /// Distance between the hand and the place where the user sees the drawn tool, at 9×9×9 points of the workspace.
  Colocation colocation(const BenchState& bench);

 private:
  std::size_t many(double count) const;
  dvec3 slip() { return random_.in_box(dvec3(-4e-4 * options_.soft), dvec3(4e-4 * options_.soft)); }
  SimulationOptions options_;
  Noise random_;
  ArmGeometry arm_;
  RigGeometry truth_;
};

/// Calibrates from the workbench's nominal dimensions. For each step: simulates captures, then solves the step.
struct SimulatedRoutine {
  Captures captures;
  BenchState bench;
  BenchSimulator::Colocation before, after;
};
SimulatedRoutine simulate_routine(const SimulationOptions& options);

}  // namespace typodont::calibration

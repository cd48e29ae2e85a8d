// A mirror bench with a wrong arm, a displaced panel and mirror, and a user of individual eyes and unsteady hand.
#pragma once

#include <cstdint>

#include "calibration/routine.h"
#include "calibration/statistics.h"

namespace typodont::calibration {

struct SimulationOptions {
  std::uint64_t seed = 1;
  double touch_noise = 2e-4;  // m per axis
  double slipped = 0.02;      // fraction of the touches that miss by millimetres
  bool arm_errors = true;     // ±1 mm in links, ±1° in joints, ±0.5 % in scales
  // m and rad, from the drawings; angles of panel, base and eyes up to twice this
  double placement_error = 0.02;
  // m, felt minus seen
  dvec3 user_offset{0.0004, -0.0003, 0.0012};
  double delay = 0.0234;  // s, delay of the display relative to the arm
  double touches = 1;     // factor of every step's touches
};

class BenchSimulator {
 public:
  explicit BenchSimulator(const SimulationOptions& options);

  const ArmGeometry& true_arm() const { return arm_; }
  const RigGeometry& truth() const { return truth_; }
  /// The drawings, with which the routine starts.
  BenchState drawings() const;

  /// Readings of an arm whose tip is at p_W (m); arbitrary wrist.
  ArmReading hold(const dvec3& p_W);
  /// An unsteady touch of p_W (m), computed with `believed_arm`.
  Touch touch(const dvec3& p_W, const ArmGeometry& believed_arm);
  /// Where this user puts the tip for a point drawn at p_W.
  dvec3 reached_for(const RigGeometry& believed, const dvec3& p_W) const;

  // Captures of one step; `bench`: the estimate before it.
  void capture_arm(Captures& captures, const BenchState& bench);
  void capture_screen(Captures& captures, const BenchState& bench);
  void capture_eyes(Captures& captures, const BenchState& bench);
  void capture_register(Captures& captures, const BenchState& bench);
  void capture_delay(Captures& captures, const BenchState& bench);
  void capture_verify(Captures& captures, const BenchState& bench);

  struct Colocation {
    double rms = 0, worst = 0, mean = 0;  // m over all points
  };
  /// Distance between the hand and where the user sees the drawn tool, at 9×9×9 points.
  Colocation colocation(const BenchState& bench);

 private:
  std::size_t many(double count) const;
  SimulationOptions options_;
  Noise random_;
  ArmGeometry arm_;
  RigGeometry truth_;
};

/// From the drawings, step by step: capture, then solve.
struct SimulatedRoutine {
  Captures captures;
  BenchState bench;
  BenchSimulator::Colocation before, after;
};
SimulatedRoutine simulate_routine(const SimulationOptions& options);

}  // namespace typodont::calibration

// The complete calibration routine: from raw captures to a calibrated bench. Every step can be solved again from its
// captures. README.md of this folder has an overview and defines the terms.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "calibration/arm_solver.h"
#include "calibration/delay_solver.h"
#include "calibration/eyes_solver.h"
#include "calibration/registration_solver.h"
#include "calibration/rig_geometry.h"
#include "calibration/screen_solver.h"
#include "calibration/verify.h"

namespace typodont::calibration {

/// One touch: the position of the stylus tip that the arm reported (frame H, m), and the arm's encoder readings if
/// available. From the readings, the tip's position can be computed again after the arm's geometry was calibrated.
struct Touch {
  dvec3 p_H{0, 0, 0};
  std::optional<ArmReading> reading;
  dvec3 at(const ArmGeometry& arm) const { return reading ? tip_position(arm, *reading) : p_H; }
};

struct MarkCapture {
  PanelPoint mark;
  Touch touch;
};
struct EyeCapture {
  bool right = false;
  PanelPoint dot;
  Touch touch;
};
struct PairCapture {
  dvec3 shown_D{0, 0, 0};
  Touch touch;
  // The two dots, one for each eye, that showed the point on the panel. From the dots, the position at which the user
  // saw the point can be computed again after the positions of the user's eyes were calibrated.
  std::optional<Dots> dots;
  /// Returns the position (frame D, m) at which the user saw the point, for the panel and the eyes of `rig`. Without
  /// dots, returns shown_D.
  dvec3 shown(const RigGeometry& rig) const;
};

/// Raw captures (recorded touches) of each step; an empty step was skipped.
struct Captures {
  std::vector<ArmCapture> arm;
  std::vector<MarkCapture> marks;
  std::vector<Touch> mirror;
  std::vector<EyeCapture> eyes;
  std::vector<PairCapture> registration, verification;
  std::vector<Touch> drift_marks;
  Stream delay_a, delay_b;
};

/// Writes one CSV file per step to a folder (arm.csv, marks.csv, mirror.csv, eyes.csv, register.csv, verify.csv,
/// drift.csv, delay_a.csv, delay_b.csv). Steps without captures have no file. Throws Error.
void write_captures(const std::filesystem::path& folder, const Captures& captures);
Captures read_captures(const std::filesystem::path& folder);
// Each of the functions read_arm_captures() to read_pair_captures() reads the captures of one calibration step from its
// file.
std::vector<ArmCapture> read_arm_captures(const std::filesystem::path& file);
std::vector<MarkCapture> read_mark_captures(const std::filesystem::path& file);
std::vector<Touch> read_touches(const std::filesystem::path& file);
std::vector<EyeCapture> read_eye_captures(const std::filesystem::path& file);
std::vector<PairCapture> read_pair_captures(const std::filesystem::path& file);

struct JointResult;

/// The present estimate of a bench, and the result of each calibration step.
struct BenchState {
  ArmGeometry arm;
  RigGeometry rig;  // geometry in frame W, which equals frame D of the display
  Box workspace_D{dvec3(-0.04), dvec3(0.04)};
  Tolerance tolerance;
  std::optional<ArmResult> arm_result;
  std::optional<PanelResult> panel_result;
  std::optional<MirrorResult> mirror_result;
  std::optional<EyesResult> eyes_result;
  std::shared_ptr<const JointResult>
      joint;  // result of solving all captures together; null if there were not enough captures to compute it
  std::optional<RegistrationResult> registration;
  std::optional<VerifyResult> verification;
  std::optional<DelayResult> delay;
};

// Each function with a name solve_…_step() solves one calibration step. If the captures determine the result, the bench
// uses this result from then on. Otherwise the bench keeps its old values. Throws Error.
void solve_arm_step(BenchState& bench, const Captures& captures);
void solve_screen_step(BenchState& bench, const Captures& captures, double tip_radius = 0);
/// Estimates the eyes. `user_offset`: true if the user's systematic offset between seeing and feeling is estimated,
/// too, from the touches of the step `register` or `verify`.
void solve_eyes_step(BenchState& bench, const Captures& captures, bool user_offset = false);
/// Returns the eyes as determined only by the alignments (stylus tip in front of a dot).
EyesResult eyes_of(const BenchState& bench, const Captures& captures);
/// Solves all captures jointly if they are sufficient (joint_solver.h), then does the rigid registration.
void solve_register_step(BenchState& bench, const Captures& captures);
void solve_delay_step(BenchState& bench, const Captures& captures);
void solve_verify_step(BenchState& bench, const Captures& captures);
/// Solves every calibration step that has captures, in order.
void solve_all(BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration

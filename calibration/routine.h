// Calibrates a workbench (arm, panel, mirror, eyes) from captures, in steps. Every step can be repeated (README.md).
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

/// A touch: position of the tip (haptic frame H, m) and the encoder readings, from which the position can be computed
/// again after a calibration of the arm.
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
  // Dots on the panel, showing the point. After a calibration of the eyes, the dots give a new position of the point.
  std::optional<Dots> dots;
  /// Position (display frame D, m) at which the user saw the point: computed from `dots` with `rig`; if empty, shown_D.
  dvec3 shown(const RigGeometry& rig) const;
};

/// Captures of all steps. A step without captures was skipped.
struct Captures {
  std::vector<ArmCapture> arm;
  std::vector<MarkCapture> marks;
  std::vector<Touch> mirror;
  std::vector<EyeCapture> eyes;
  std::vector<PairCapture> registration, verification;
  std::vector<Touch> drift_marks;
  Stream delay_a, delay_b;
};

/// Writes one CSV file for each step that has captures: arm, marks, mirror, eyes, register, verify, drift, delay_a,
/// delay_b. `only`: the file to write, for example "arm.csv"; empty: all. Throws Error.
void write_captures(const std::filesystem::path& folder, const Captures& captures, std::string_view only = {});
Captures read_captures(const std::filesystem::path& folder);
// Each function reads one step's file of captures.
std::vector<ArmCapture> read_arm_captures(const std::filesystem::path& file);
std::vector<MarkCapture> read_mark_captures(const std::filesystem::path& file);
std::vector<Touch> read_touches(const std::filesystem::path& file);
std::vector<EyeCapture> read_eye_captures(const std::filesystem::path& file);
std::vector<PairCapture> read_pair_captures(const std::filesystem::path& file);

struct JointResult;

/// Current estimate of the workbench's geometry, and the result of each calibration step.
struct BenchState {
  ArmGeometry arm;
  RigGeometry rig;  // in this rig, the world frame W is the display's frame D
  Box workspace_D{dvec3(-0.04), dvec3(0.04)};
  Tolerance tolerance;
  std::optional<ArmResult> arm_result;
  std::optional<PanelResult> panel_result;
  std::optional<MirrorResult> mirror_result;
  std::optional<EyesResult> eyes_result;
  std::shared_ptr<const JointResult> joint;  // result of the joint solution; null: there were not enough captures
  std::optional<RegistrationResult> registration;
  std::optional<VerifyResult> verification;
  std::optional<DelayResult> delay;
};

// Each function solves one calibration step. If the captures determine the result, it is stored in `bench`; otherwise
// `bench` keeps its values. Throws Error.
void solve_arm_step(BenchState& bench, const Captures& captures);
void solve_screen_step(BenchState& bench, const Captures& captures, double tip_radius = 0);
/// `user_offset`: also computes the user's offset, from the touches of `register` or `verify`.
void solve_eyes_step(BenchState& bench, const Captures& captures, bool user_offset = false);
/// Computes the eyes' positions only from captures in which the user aligned the stylus tip with a dot on the panel.
EyesResult eyes_of(const BenchState& bench, const Captures& captures);
/// Solves all steps jointly if possible (joint_solver.h), then the registration.
void solve_register_step(BenchState& bench, const Captures& captures);
void solve_delay_step(BenchState& bench, const Captures& captures);
void solve_verify_step(BenchState& bench, const Captures& captures);
/// Solves every calibration step that has captures, in order.
void solve_all(BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration

// The whole set-up routine: raw captures in, one calibrated bench out. Every step can be solved again from its
// captures.
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

/// A touch as it was captured: the point as the arm then gave it, and the encoders where the arm has them, so that the
/// point can be computed again when the arm's geometry is known better.
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
  std::optional<Dots>
      dots;  // what the panel showed; with it the point can be placed again when the eyes are known better
  /// Where the point appears, by what is believed now.
  dvec3 shown(const RigGeometry& rig) const;
};

/// Raw captures, step by step; an empty step was skipped.
struct Captures {
  std::vector<ArmCapture> arm;
  std::vector<MarkCapture> marks;
  std::vector<Touch> mirror;
  std::vector<EyeCapture> eyes;
  std::vector<PairCapture> registration, verification;
  std::vector<Touch> drift_marks;
  Stream delay_a, delay_b;
};

/// One CSV per step in a folder (arm.csv, marks.csv, mirror.csv, eyes.csv, register.csv, verify.csv, drift.csv,
/// delay_a.csv, delay_b.csv). Steps without captures have no file. Throws Error.
void write_captures(const std::filesystem::path& folder, const Captures& captures);
Captures read_captures(const std::filesystem::path& folder);
// Each file alone.
std::vector<ArmCapture> read_arm_captures(const std::filesystem::path& file);
std::vector<MarkCapture> read_mark_captures(const std::filesystem::path& file);
std::vector<Touch> read_touches(const std::filesystem::path& file);
std::vector<EyeCapture> read_eye_captures(const std::filesystem::path& file);
std::vector<PairCapture> read_pair_captures(const std::filesystem::path& file);

struct JointResult;

/// What is believed of a bench, and what each step found.
struct BenchState {
  ArmGeometry arm;
  RigGeometry rig;  // frame W = D
  Box workspace_D{dvec3(-0.04), dvec3(0.04)};
  Tolerance tolerance;
  std::optional<ArmResult> arm_result;
  std::optional<PanelResult> panel_result;
  std::optional<MirrorResult> mirror_result;
  std::optional<EyesResult> eyes_result;
  std::shared_ptr<const JointResult> joint;  // of all captures; only where the dots were recorded
  std::optional<RegistrationResult> registration;
  std::optional<VerifyResult> verification;
  std::optional<DelayResult> delay;
};

// Each solves one step from its captures and takes the answer over, unless it is not determined. Throws Error.
void solve_arm_step(BenchState& bench, const Captures& captures);
void solve_screen_step(BenchState& bench, const Captures& captures, double tip_radius = 0);
/// `user_offset`: the user's systematic offset between seeing and feeling too, from the touches of register or verify.
void solve_eyes_step(BenchState& bench, const Captures& captures, bool user_offset = false);
/// What the alignments alone say of the eyes.
EyesResult eyes_of(const BenchState& bench, const Captures& captures);
/// First all captures jointly where they suffice (joint_solver.h), then the rigid registration.
void solve_register_step(BenchState& bench, const Captures& captures);
void solve_delay_step(BenchState& bench, const Captures& captures);
void solve_verify_step(BenchState& bench, const Captures& captures);
/// Every step that has captures, in order.
void solve_all(BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration

// The haptic arm's own geometry, from the stylus tip resting in fixed sockets and touching a plate of known points.
// Only what the captures determine is fitted; the rest keeps its value and is named. SI; any thread; set-up time.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Joint angles A to F as the encoders give them, before calibration.
struct ArmReading {
  std::array<double, 6> angle{};  // rad
};

/// A serial arm as WoodenHaptics and Polhem (reference: their published kinematics; angles B, C absolute; x towards the
/// user, y right, z up). True angle = scale · reading + offset.
struct ArmGeometry {
  double base = 0.080, upper = 0.205, fore = 0.245;  // m: La, Lb, Lc
  dvec3 origin{0.220, 0, 0.080};                     // m, of H from the foot of the arm
  std::array<double, 6> offset{};                    // rad
  std::array<double, 3> scale{1, 1, 1};              // of the encoders of A, B, C
  dvec3 tip_S{0.12, 0, 0};                           // m, the stylus tip from the wrist's centre, x along the stylus
};

inline constexpr std::size_t kArmParameters = 18;
/// In the order of to_vector: "upper link", …
std::span<const char* const> arm_parameter_names();
/// By how much each may plausibly be off: 1 mm, 1°, 0.5 %. The unit in which "determined" is judged.
std::array<double, kArmParameters> arm_parameter_scales();
std::array<double, kArmParameters> to_vector(const ArmGeometry& geometry);
ArmGeometry to_geometry(const std::array<double, kArmParameters>& parameters);

Pose stylus_pose(const ArmGeometry& geometry, const ArmReading& reading);    // X_HS, at the wrist's centre
dvec3 tip_position(const ArmGeometry& geometry, const ArmReading& reading);  // p_HTip
/// How the tip moves with each parameter, in the order of to_vector (m per m, rad or unit of scale).
std::array<dvec3, kArmParameters> tip_derivatives(const ArmGeometry& geometry, const ArmReading& reading);

/// One rest of the tip. Captures with one group share a socket (known empty) or a plate (known: its coordinates there).
struct ArmCapture {
  int group = 0;
  std::optional<dvec3> known;  // m, in the plate's own frame
  ArmReading reading;
};

struct ArmParameter {
  std::string name;
  double before = 0, after = 0;  // SI
  double sigma = 0;              // SI; where the captures say nothing, by how much it may plausibly be off
  double determined = 0;         // 0..1: the part of that doubt which the captures removed
};

struct ArmResult {
  ArmGeometry geometry;
  std::vector<ArmParameter> parameters;
  std::vector<std::string> not_observable;  // each a combination of parameters, in words
  double before_rms = 0, after_rms = 0;     // m, distance of the tip from where it was held, per capture
  double sigma = 0;                         // m per axis
  int degrees_of_freedom = 0;
  std::vector<std::size_t> rejected;
  std::vector<double> residuals;  // m, per capture
  std::string misfit;             // not empty: no arm of this kind explains the captures, do not use it
};

/// Throws Error when there is no capture, or one group mixes socket and plate.
ArmResult solve_arm(std::span<const ArmCapture> captures, const ArmGeometry& nominal);

}  // namespace typodont::calibration

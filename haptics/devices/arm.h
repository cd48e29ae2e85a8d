// Kinematics of WoodenHaptics and Polhem from a preset. Stateless. H: x to the user, y right, z up. Driven bodies: A
// about z, B and C from the vertical.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// SI, all from one preset: sources differ in signs and constants.
struct Arm {
  std::string name;
  enum class Linkage { kSerial, kFiveBar } linkage = Linkage::kSerial;
  // m, diameters of capstans and of bodies A, B, C
  dvec3 capstan{0}, body{0};
  double La = 0, Lb = 0, Lc = 0;                 // m, lengths of the links, if the linkage is serial
  std::array<double, 6> L{};                     // m, of a five-bar linkage
  dvec3 origin{0};                               // m, origin of the workspace in the frame of the base
  dvec3 torque_constant{0};                      // N·m/A, for each motor: torque per ampere
  std::array<double, 6> counts{};                // per turn, A…F; 0: no stylus encoders
  std::array<double, 6> sign{1, 1, 1, 1, 1, 1};  // -1: the angle falls as the count rises
  std::array<std::int64_t, 6> home{};            // counts of the six encoders in the home position
  double current_limit = 3;                      // A; the firmware has no limit
  double force_limit = 5, stiffness = 1000;      // N, largest force; N/m, largest stiffness
  double continuous_force = 0;                   // N, force that the motors can give permanently without overheating
  double vibration_band = 0;                     // Hz, largest vibration frequency that the arm can render
  double silence = 0;                            // s without a write until zero force; 0: 1.8 ms
  // rad/s; faster counts are encoder errors
  double joint_speed = 30;
  // Gravity of B and C: masses, and centres from the joints.
  double mass_b = 0, mass_c = 0, center_b = 0, center_c = 0;  // kg, m

  bool has_stylus() const { return counts[3] > 0 && counts[4] > 0 && counts[5] > 0; }
  double ratio(int i) const { return capstan[i] / body[i]; }
  /// Counts of encoder i within dt (s).
  std::int64_t reach(int i, double dt) const;
};

/// Reads the preset file assets/devices/NAME.json. Throws Error.
Arm read_arm(const std::filesystem::path& file);

using Counts = std::array<std::int64_t, 6>;

/// rad, A, B, C.
dvec3 body_angles(const Arm& arm, const Counts& counts);
/// rad, D, E, F; invalid without encoders.
dvec3 stylus_angles(const Arm& arm, const Counts& counts);
/// Tip in H. The orientation was not verified on hardware.
Pose stylus_pose(const Arm& arm, const Counts& counts);
dvec3 stylus_position(const Arm& arm, const dvec3& theta);
/// ∂p/∂A, ∂p/∂B, ∂p/∂C, m/rad.
glm::dmat3 jacobian(const Arm& arm, const dvec3& theta);
/// m, one count of A, B and C at home.
double position_step(const Arm& arm);
/// N·m on A, B, C against weight; zero without masses.
dvec3 gravity_torque(const Arm& arm, const dvec3& theta);

struct Currents {
  dvec3 amperes{0};
  bool clipped = false;
};
/// For a force (N, H) and `holding` (N·m). Beyond a limit, all scaled alike: the direction stays.
Currents motor_currents(const Arm& arm, const dvec3& theta, const dvec3& f_S_H, const dvec3& holding);

}  // namespace typodont::haptics

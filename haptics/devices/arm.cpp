#include "haptics/devices/arm.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/described.h"

namespace typodont::haptics {

namespace {

/// acos with a clamped argument, so that a rounding error or a wrong encoder count gives no NaN.
double angle_of(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

struct FiveBar {
  double rho, z, lambda;
};
/// Forearm of the Polhem arm: the motors of bodies B and C (angles t2, t3) drive two cranks. Returns its position (rho,
/// z) and angle lambda.
FiveBar five_bar(const Arm& arm, double t2, double t3) {
  const auto& L = arm.L;
  const double px = L[0] + L[1] * std::cos(t2), py = L[1] * std::sin(t2);
  const double qx = px - L[2] * std::cos(t3), qy = py - L[2] * std::sin(t3);
  const double p = std::hypot(px, py), q = std::hypot(qx, qy);
  const double lambda = t2 - angle_of((p * p + L[1] * L[1] - L[0] * L[0]) / (2 * L[1] * p)) -
                        angle_of((q * q + L[4] * L[4] - L[3] * L[3]) / (2 * L[4] * q)) -
                        angle_of((p * p + q * q - L[2] * L[2]) / (2 * p * q));
  return {L[0] / 2 + L[1] * std::cos(t2) + L[5] * std::cos(lambda), L[1] * std::sin(t2) + L[5] * std::sin(lambda),
          lambda};
}

}  // namespace

std::int64_t Arm::reach(int i, double dt) const {
  const double turns_per_radian = i < 3 ? 1 / ratio(i) : 1.0;
  const double per_second = joint_speed * turns_per_radian * counts[static_cast<std::size_t>(i)] / (2 * kPi);
  return std::min<std::int64_t>(32'000, static_cast<std::int64_t>(per_second * dt) + 8);
}

namespace {

void describe_gravity(Keys& keys, Arm& arm) {
  if (keys.json() && arm.linkage != Arm::Linkage::kSerial)
    keys.json()->fail("a serial linkage, where the masses act as written");
  keys(must("mass_b_kg"), arm.mass_b, {0, 5}, "mass of the body B");
  keys(must("mass_c_kg"), arm.mass_c, {0, 5}, "mass of the body C");
  keys(must("center_b_mm"), arm.center_b, {0, 2000, kMillimetre}, "distance of the centre of mass of B from its joint");
  keys(must("center_c_mm"), arm.center_c, {0, 2000, kMillimetre}, "distance of the centre of mass of C from its joint");
}

void describe_arm(Keys& keys, Arm& arm) {
  const auto positive = [&](const char* name, dvec3& value, double unit, std::string_view meaning) {
    const auto json = keys(must(name), kThree, meaning);
    if (!json) return;
    const dvec3 v = json->vec3();
    if (!(v.x > 0 && v.y > 0 && v.z > 0)) json->fail("three positive numbers");
    value = v * unit;
  };
  keys(must("name"), arm.name, "name of the arm");
  keys.ignore("source");
  keys(must("linkage"), arm.linkage, {"serial", "five_bar"}, "linkage of the bodies B and C");
  positive("capstan_mm", arm.capstan, kMillimetre, "diameters of the motors' capstans");
  positive("body_mm", arm.body, kMillimetre, "diameters of the bodies A, B, C");
  if (const auto json =
          keys(must("lengths_mm"), kNumbers, "lengths of the 3 (`serial`) or 6 (`five_bar`) links, 0–2000")) {
    const bool serial = arm.linkage == Arm::Linkage::kSerial;
    std::vector<double> lengths = json->numbers(serial ? 3 : 6);
    for (double& l : lengths) {
      if (!(l > 0 && l < 2000)) json->fail("lengths of 0 to 2000");
      l *= kMillimetre;
    }
    if (serial)
      arm.geometry.base = lengths[0], arm.geometry.upper = lengths[1], arm.geometry.fore = lengths[2];
    else
      std::ranges::copy(lengths, arm.L.begin());
  }
  keys(must("origin_mm"), arm.geometry.origin, kMillimetre, "origin of the frame H relative to the arm's foot");
  positive("torque_constant_Nm_per_A", arm.torque_constant, 1, "torque of each motor per ampere");
  if (const auto json =
          keys(must("encoder_counts"), kNumbers, "counts per turn of the encoders A to F; 0 (D, E, F): no encoder")) {
    const std::vector<double> counts = json->numbers(6);
    for (std::size_t i = 0; i < 6; ++i) {
      if (counts[i] < (i < 3 ? 1 : 0) || counts[i] > 1e6) json->fail("1 to 1e6 for A, B, C; 0 to 1e6 for D, E, F");
      arm.counts[i] = counts[i];
    }
  }
  if (const auto json = keys(must("aligned"), kNumbers, "for each encoder 1: the angle falls when the count rises")) {
    const std::vector<double> aligned = json->numbers(6);
    for (std::size_t i = 0; i < 6; ++i) {
      if (aligned[i] != 0 && aligned[i] != 1) json->fail("six flags, 0 or 1");
      arm.sign[i] = aligned[i] == 1 ? -1 : 1;
    }
  }
  const auto home = keys("home_counts", kNumbers, "counts of the six encoders in the home position");
  const auto degrees = keys("home_deg", kThree, "instead of `home_counts`: angles of A, B, C in the home position");
  if (degrees) {
    if (home) degrees->fail("either home_deg or home_counts");
    const dvec3 theta = degrees->vec3() * kDegree;
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      arm.home[k] = std::llround(arm.sign[k] * theta[i] / arm.ratio(i) * arm.counts[k] / (2 * kPi));
    }
  } else if (const Json* json = keys.json()) {
    const std::vector<double> counts = (*json)["home_counts"].numbers(6);
    for (std::size_t i = 0; i < 6; ++i) {
      if (std::abs(counts[i]) > 1e6) home->fail("counts of at most a million");
      arm.home[i] = std::llround(counts[i]);
    }
  }
  constexpr double kMaxForce = 200;  // N
  keys("current_limit_A", arm.current_limit, {0.01, 20}, "largest motor current");
  keys(must("force_limit_N"), arm.force_limit, {0.01, kMaxForce}, "largest force");
  keys(must("stiffness_N_per_m"), arm.stiffness, {1, 1e5}, "largest stiffness");
  keys("continuous_force_N", arm.continuous_force, {0, keys.json() ? arm.force_limit : kMaxForce},
       "force that the motors can give permanently; at most `force_limit_N`");
  keys("joint_speed_rad_per_s", arm.joint_speed, {1, 1000},
       "largest speed of a joint; a faster change of a count is an encoder error");
  keys("vibration_band_Hz", arm.vibration_band, {0, 1000}, "largest vibration frequency");
  keys("silence_ms", arm.silence, {0, 20, 1e-3}, "time without a write after which the force becomes zero; 0: 1.8 ms");
  keys("gravity", arm, describe_gravity, "masses of a `serial` arm, to compensate its weight");
}

}  // namespace

Arm read_arm(const std::filesystem::path& file) {
  return read_keys(Json::load(file), describe_arm);
}

void list_arm(Keys& keys) {
  Arm arm;
  describe_arm(keys, arm);
}

dvec3 body_angles(const Arm& arm, const Counts& counts) {
  dvec3 theta;
  for (int i = 0; i < 3; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    theta[i] = arm.sign[k] * 2 * kPi * static_cast<double>(counts[k]) / arm.counts[k] * arm.ratio(i);
  }
  return theta;
}

void use_measured(Arm& arm, const ArmGeometry& geometry) {
  if (arm.linkage != Arm::Linkage::kSerial || !arm.has_stylus())
    throw Error("calibration.arm", "", "the geometry of another arm than " + arm.name,
                "a serial arm with encoders of the stylus, or no step `arm` in the rig");
  arm.geometry = geometry;
}

namespace {

ArmReading reading_of(const Arm& arm, const Counts& counts) {
  const dvec3 body = body_angles(arm, counts), stylus = stylus_angles(arm, counts);
  return {{body.x, body.y, body.z, stylus.x, stylus.y, stylus.z}};
}

}  // namespace

dvec3 true_angles(const Arm& arm, const Counts& counts) {
  const auto q = arm_joints(arm.geometry, reading_of(arm, counts)).q;
  return {q[0], q[1], q[2]};
}

dvec3 stylus_position(const Arm& arm, const dvec3& theta) {
  if (arm.linkage == Arm::Linkage::kSerial) return wrist_position(arm.geometry, {theta.x, theta.y, theta.z});
  const FiveBar bar = five_bar(arm, theta.y, theta.z);
  return dvec3(bar.rho * std::cos(theta.x), bar.rho * std::sin(theta.x), bar.z) - arm.geometry.origin;
}

dvec3 stylus_angles(const Arm& arm, const Counts& counts) {
  dvec3 angles;
  for (int i = 0; i < 3; ++i) {
    const std::size_t k = 3 + static_cast<std::size_t>(i);
    angles[i] = arm.sign[k] * 2 * kPi * static_cast<double>(counts[k]) / arm.counts[k];
  }
  return angles;
}

Pose stylus_pose(const Arm& arm, const Counts& counts) {
  const dvec3 theta = body_angles(arm, counts);
  if (!arm.has_stylus()) return {stylus_position(arm, theta), {1, 0, 0, 0}};
  if (arm.linkage == Arm::Linkage::kSerial) {
    const Pose X_HS = typodont::stylus_pose(arm.geometry, reading_of(arm, counts));
    return {X_HS * arm.geometry.tip_S, X_HS.R};
  }
  const dvec3 stylus = stylus_angles(arm, counts);
  const double tilt = -five_bar(arm, theta.y, theta.z).lambda;
  const auto turn = [](double angle, const dvec3& axis) { return glm::angleAxis(angle, axis); };
  const dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {stylus_position(arm, theta), glm::normalize(turn(theta.x, z) * turn(tilt, y) * turn(stylus[0], x) *
                                                      turn(stylus[1], y) * turn(stylus[2], x))};
}

glm::dmat3 jacobian(const Arm& arm, const dvec3& theta) {
  if (arm.linkage == Arm::Linkage::kFiveBar) {
    // Derivatives by central differences with steps of 1e-6 rad, exact to nine digits; a closed form would be longer.
    constexpr double kStep = 1e-6;
    glm::dmat3 J;
    for (int i = 0; i < 3; ++i) {
      dvec3 a = theta, b = theta;
      a[i] -= kStep, b[i] += kStep;
      J[i] = (stylus_position(arm, b) - stylus_position(arm, a)) / (2 * kStep);
    }
    return J;
  }
  const double sA = std::sin(theta.x), cA = std::cos(theta.x), sB = std::sin(theta.y), cB = std::cos(theta.y),
               sC = std::sin(theta.z), cC = std::cos(theta.z);
  const double upper = arm.geometry.upper, fore = arm.geometry.fore, r = upper * sB + fore * sC;
  return {dvec3(-sA * r, cA * r, 0), upper * dvec3(cA * cB, sA * cB, -sB), fore * dvec3(cA * cC, sA * cC, sC)};
}

double position_step(const Arm& arm) {
  const glm::dmat3 J = jacobian(arm, true_angles(arm, arm.home));
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    // Rotation of body i per encoder count, rad.
    const double count = 2 * kPi / arm.counts[static_cast<std::size_t>(i)] * arm.ratio(i);
    sum += glm::dot(J[i], J[i]) * count * count;
  }
  return std::sqrt(sum);
}

dvec3 gravity_torque(const Arm& arm, const dvec3& theta) {
  constexpr double g = 9.81;  // m/s², acceleration of gravity
  return {0, -g * (arm.mass_b * arm.center_b + arm.mass_c * arm.geometry.upper) * std::sin(theta.y),
          g * arm.mass_c * arm.center_c * std::sin(theta.z)};
}

Currents motor_currents(const Arm& arm, const dvec3& theta, const dvec3& f_S_H, const dvec3& holding) {
  const dvec3 tau = glm::transpose(jacobian(arm, theta)) * f_S_H + holding;
  Currents out;
  double worst = 0;
  for (int i = 0; i < 3; ++i) {
    out.amperes[i] = arm.sign[static_cast<std::size_t>(i)] * tau[i] * arm.ratio(i) / arm.torque_constant[i];
    worst = std::max(worst, std::abs(out.amperes[i]));
  }
  if (!is_finite(out.amperes)) return {dvec3(0), true};
  if (worst > arm.current_limit) {
    out.amperes *= arm.current_limit / worst;
    out.clipped = true;
  }
  return out;
}

}  // namespace typodont::haptics

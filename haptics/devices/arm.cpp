#include "haptics/devices/arm.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

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

Arm read_arm(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  json.allow_only({"name",
                   "source",
                   "linkage",
                   "capstan_mm",
                   "body_mm",
                   "lengths_mm",
                   "origin_mm",
                   "torque_constant_Nm_per_A",
                   "encoder_counts",
                   "aligned",
                   "home_counts",
                   "home_deg",
                   "current_limit_A",
                   "force_limit_N",
                   "stiffness_N_per_m",
                   "continuous_force_N",
                   "joint_speed_rad_per_s",
                   "vibration_band_Hz",
                   "silence_ms",
                   "gravity"});
  Arm arm;
  arm.name = json["name"].string();
  const std::string linkage = json["linkage"].string();
  if (linkage != "serial" && linkage != "five_bar") json["linkage"].fail("serial or five_bar");
  arm.linkage = linkage == "serial" ? Arm::Linkage::kSerial : Arm::Linkage::kFiveBar;

  const auto positive3 = [&](const char* key) {
    const dvec3 v = json[key].vec3();
    if (!(v.x > 0 && v.y > 0 && v.z > 0)) json[key].fail("three positive numbers");
    return v;
  };
  arm.capstan = positive3("capstan_mm") * kMillimetre;
  arm.body = positive3("body_mm") * kMillimetre;
  arm.torque_constant = positive3("torque_constant_Nm_per_A");
  const std::size_t links = arm.linkage == Arm::Linkage::kSerial ? 3 : 6;
  const std::vector<double> lengths = json["lengths_mm"].numbers(links);
  for (const double l : lengths) {
    if (!(l > 0 && l < 2000)) json["lengths_mm"].fail("lengths of 0 to 2000");
  }
  if (links == 3) {
    arm.geometry.base = lengths[0] * kMillimetre;
    arm.geometry.upper = lengths[1] * kMillimetre, arm.geometry.fore = lengths[2] * kMillimetre;
  } else {
    for (std::size_t i = 0; i < 6; ++i) arm.L[i] = lengths[i] * kMillimetre;
  }
  arm.geometry.origin = json["origin_mm"].vec3() * kMillimetre;

  const std::vector<double> counts = json["encoder_counts"].numbers(6);
  for (std::size_t i = 0; i < 6; ++i) {
    if (counts[i] < (i < 3 ? 1 : 0) || counts[i] > 1e6)
      json["encoder_counts"].fail("1 to 1e6 for A, B, C; 0 to 1e6 for D, E, F");
    arm.counts[i] = counts[i];
  }
  const std::vector<double> aligned = json["aligned"].numbers(6);
  for (std::size_t i = 0; i < 6; ++i) {
    if (aligned[i] != 0 && aligned[i] != 1) json["aligned"].fail("six flags, 0 or 1");
    arm.sign[i] = aligned[i] == 1 ? -1 : 1;
  }

  arm.current_limit = json.number_or("current_limit_A", arm.current_limit, 0.01, 20);
  arm.force_limit = json["force_limit_N"].number(0.01, 200);
  arm.stiffness = json["stiffness_N_per_m"].number(1, 1e5);
  arm.continuous_force = json.number_or("continuous_force_N", 0, 0, arm.force_limit);
  arm.joint_speed = json.number_or("joint_speed_rad_per_s", arm.joint_speed, 1, 1000);
  arm.vibration_band = json.number_or("vibration_band_Hz", 0, 0, 1000);
  arm.silence = json.number_or("silence_ms", 0, 0, 20) * 1e-3;
  if (const auto gravity = json.find("gravity")) {
    gravity->allow_only({"mass_b_kg", "mass_c_kg", "center_b_mm", "center_c_mm"});
    if (links != 3) gravity->fail("a serial linkage, where the masses act as written");
    arm.mass_b = (*gravity)["mass_b_kg"].number(0, 5);
    arm.mass_c = (*gravity)["mass_c_kg"].number(0, 5);
    arm.center_b = (*gravity)["center_b_mm"].number(0, 2000) * kMillimetre;
    arm.center_c = (*gravity)["center_c_mm"].number(0, 2000) * kMillimetre;
  }

  if (const auto degrees = json.find("home_deg")) {
    if (json.has("home_counts")) degrees->fail("either home_deg or home_counts");
    const dvec3 theta = degrees->vec3() * kDegree;
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      arm.home[k] = std::llround(arm.sign[k] * theta[i] / arm.ratio(i) * arm.counts[k] / (2 * kPi));
    }
  } else {
    const std::vector<double> home = json["home_counts"].numbers(6);
    for (std::size_t i = 0; i < 6; ++i) {
      if (std::abs(home[i]) > 1e6) json["home_counts"].fail("counts of at most a million");
      arm.home[i] = std::llround(home[i]);
    }
  }
  return arm;
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

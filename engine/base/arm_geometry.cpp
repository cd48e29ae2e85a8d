#include "engine/base/arm_geometry.h"

#include <algorithm>
#include <cmath>

#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr std::array<const char*, kArmParameters> kNames = {
    "upper link", "fore link",   "offset A", "offset B", "offset C", "scale A", "scale B",
    "scale C",    "base height", "origin x", "origin y", "origin z", "tip x",   "tip y",
    "tip z",      "offset D",    "offset E", "offset F", "sag B",    "sag C"};

}  // namespace

ArmJoints arm_joints(const ArmGeometry& arm, const ArmReading& reading) {
  ArmJoints joints;
  auto& q = joints.q;
  for (std::size_t i = 0; i < 6; ++i) q[i] = (i < 3 ? arm.scale[i] : 1.0) * reading.angle[i] + arm.offset[i];
  const double fore = arm.fore * std::sin(q[2]);
  joints.before = {q[1], q[2]};
  joints.lever = {arm.upper * std::sin(q[1]) + fore, fore};
  for (std::size_t i = 0; i < 2; ++i) q[1 + i] += arm.sag[i] * joints.lever[i];
  return joints;
}

dvec3 wrist_position(const ArmGeometry& arm, const std::array<double, 6>& q) {
  // x = cosA r - ox, y = sinA r - oy, z = La + Lb cosB - Lc cosC - oz, r = Lb sinB + Lc sinC.
  const double r = arm.upper * std::sin(q[1]) + arm.fore * std::sin(q[2]);
  return dvec3(r * std::cos(q[0]), r * std::sin(q[0]),
               arm.base + arm.upper * std::cos(q[1]) - arm.fore * std::cos(q[2])) -
         arm.origin;
}

Pose stylus_pose(const ArmGeometry& arm, const ArmReading& reading) {
  const auto q = arm_joints(arm, reading).q;
  const dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {wrist_position(arm, q), glm::angleAxis(q[0], z) * glm::angleAxis(0.5 * kPi - q[2], y) *
                                      glm::angleAxis(q[3], x) * glm::angleAxis(q[4], y) * glm::angleAxis(q[5], x)};
}

dvec3 tip_position(const ArmGeometry& arm, const ArmReading& reading) {
  return stylus_pose(arm, reading) * arm.tip_S;
}

std::span<const char* const> arm_parameter_names() {
  return kNames;
}

ArmUnit arm_parameter_unit(std::string_view parameter) {
  if (parameter.starts_with("offset")) return {kDegree, "deg", "_deg"};
  if (parameter.starts_with("scale")) return {1, "", ""};
  if (parameter.starts_with("sag")) return {kDegree, "deg/m", "_deg_per_m"};
  return {kMillimetre, "mm", "_mm"};
}

std::array<double, kArmParameters> to_vector(const ArmGeometry& g) {
  return {g.upper,    g.fore,      g.offset[0], g.offset[1], g.offset[2], g.scale[0], g.scale[1],
          g.scale[2], g.base,      g.origin.x,  g.origin.y,  g.origin.z,  g.tip_S.x,  g.tip_S.y,
          g.tip_S.z,  g.offset[3], g.offset[4], g.offset[5], g.sag[0],    g.sag[1]};
}

ArmGeometry to_geometry(const std::array<double, kArmParameters>& v) {
  return {v[8],
          v[0],
          v[1],
          {v[9], v[10], v[11]},
          {v[2], v[3], v[4], v[15], v[16], v[17]},
          {v[5], v[6], v[7]},
          {v[12], v[13], v[14]},
          {v[18], v[19]}};
}

std::string arm_parameter_key(std::string name) {
  const char* const suffix = arm_parameter_unit(name).suffix;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name + suffix;
}

ArmGeometry read_arm_geometry(const Json& json) {
  std::array<double, kArmParameters> v = to_vector(ArmGeometry{});
  for (std::size_t i = 0; i < v.size(); ++i)
    if (const auto found = json.find(arm_parameter_key(kNames[i])))
      v[i] = found->number() * arm_parameter_unit(kNames[i]).si;
  return to_geometry(v);
}

}  // namespace typodont

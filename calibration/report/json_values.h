// Writes poses and vectors as JSON; used only by .cpp files of this module.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/pose.h"

namespace typodont::calibration {

using Value = nlohmann::ordered_json;

inline Value number_value(double x) {
  return std::isfinite(x) ? Value(x) : Value(nullptr);
}
inline Value vec3_value(const dvec3& v) {
  return {v.x, v.y, v.z};
}
inline Value mm_value(const dvec3& v) {
  return {v.x * 1e3, v.y * 1e3, v.z * 1e3};
}
inline Value pose_value(const Pose& X) {
  return {{"translation_mm", mm_value(X.p)}, {"rotation_wxyz", {X.R.w, X.R.x, X.R.y, X.R.z}}};
}

}  // namespace typodont::calibration

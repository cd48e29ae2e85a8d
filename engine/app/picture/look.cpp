#include "engine/app/picture/look.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kSteepest = 89 * kPi / 180;
constexpr double kNearest = 0.06, kFarthest = 1.2;  // m, limits of the viewer's distance from the tooth's middle
constexpr double kMaxShift = 0.05;                  // m, largest displacement of the viewed point
constexpr double kHalfAngle = 4.2 * kPi / 180;      // rad, half the vertical field of view

struct Axes {
  dvec3 toward, right, up;  // unit vectors in frame W: towards the viewer, to the viewer's right, and up
};
Axes axes_of(const Viewpoint& v) {
  const double level = std::cos(v.elevation);
  const dvec3 toward(level * std::cos(v.azimuth), level * std::sin(v.azimuth), std::sin(v.elevation));
  const dvec3 right(-std::sin(v.azimuth), std::cos(v.azimuth), 0);
  return {toward, right, glm::cross(toward, right)};
}

}  // namespace

Viewpoint clamped(const Viewpoint& from) {
  Viewpoint v = from;
  v.azimuth = std::remainder(v.azimuth, 2 * kPi);
  v.elevation = std::clamp(v.elevation, -kSteepest, kSteepest);
  v.distance = std::clamp(v.distance, kNearest, kFarthest);
  v.shift = glm::clamp(v.shift, glm::dvec2(-kMaxShift), glm::dvec2(kMaxShift));
  return v;
}

display::DisplayRig rig_of(const Viewpoint& from, const dvec3& middle_W, glm::ivec2 pixels) {
  const Axes a = axes_of(from);
  const dvec3 focus = middle_W + from.shift.x * a.right + from.shift.y * a.up;
  const double half_height = from.distance * std::tan(kHalfAngle);
  const double half_width = half_height * std::max(pixels.x, 1) / std::max(pixels.y, 1);
  display::DisplayRig rig;
  rig.kind = display::DisplayKind::kOffscreen;
  rig.screen.layout = display::Layout::kMono;
  rig.screen.pixels = pixels;
  rig.screen.lower_left = focus - half_width * a.right - half_height * a.up;
  rig.screen.lower_right = focus + half_width * a.right - half_height * a.up;
  rig.screen.upper_left = focus - half_width * a.right + half_height * a.up;
  rig.head.eye_center = focus + from.distance * a.toward;
  rig.head.right = a.right;
  return rig;
}

Viewpoint viewpoint_of(const display::DisplayRig& rig, const dvec3& middle_W) {
  const dvec3 toward = rig.head.eye_center - middle_W;
  const double length = glm::length(toward);
  Viewpoint v;
  if (length < 1e-3) return v;
  v.elevation = std::asin(std::clamp(toward.z / length, -1.0, 1.0));
  if (std::hypot(toward.x, toward.y) > 1e-6) v.azimuth = std::atan2(toward.y, toward.x);
  return clamped(v);
}

glm::dvec4 section_facing(const dvec3& through_W, const dvec3& p_WE) {
  const dvec3 away = through_W - p_WE, level(away.x, away.y, 0);
  const dvec3 n = glm::length(level) > 0.2 * glm::length(away) ? glm::normalize(level) : dvec3(0, 1, 0);
  return {n, -glm::dot(n, through_W)};
}

glm::dvec4 section_plane(const Look& look, const dvec3& middle_W, const dvec3& p_WE) {
  if (look.plane != glm::dvec4(0)) return look.plane;
  dvec3 n(0);
  n[std::clamp(look.section_axis, 0, 2)] = 1;
  const double at = glm::dot(n, middle_W) + look.section;
  const double side = glm::dot(middle_W - p_WE, n) < 0 ? -1 : 1;
  return {side * n, -side * at};
}

}  // namespace typodont

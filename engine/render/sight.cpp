#include "engine/render/sight.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/render/mirror.h"

namespace typodont::render {

namespace {

/// Corners of a box, and the corners displaced to the end of its shadow.
std::array<glm::dvec4, 16> corners_with_shadow(const BoxInWorld& box, const dvec3& key) {
  constexpr double kShadow = 2;  // length of the shadow, in diagonals of the box
  const dvec3 far = -kShadow * glm::length(box.hi - box.lo) * glm::normalize(key);
  std::array<glm::dvec4, 16> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const dvec3 p(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z);
    corners[i] = glm::dvec4(i & 8 ? p + far : p, 1);
  }
  return corners;
}

/// Returns false if all corners are outside one plane of the frustum, or behind `plane`.
bool before(const Eye& eye, const std::array<glm::dvec4, 16>& corners, const glm::dvec4& plane = {0, 0, 0, 1}) {
  const auto beyond = [&](const glm::dvec4& side) {
    return std::all_of(corners.begin(), corners.end(), [&](const glm::dvec4& p) { return glm::dot(side, p) < 0; });
  };
  const auto sides = frustum_planes(eye.projection * eye.view);
  return !beyond(plane) && std::none_of(sides.begin(), sides.end(), beyond);
}

}  // namespace

std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from) {
  const glm::dmat4 rows = glm::transpose(clip_from);
  return {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], rows[2], rows[3] - rows[2]};
}

bool in_sight(const Frame& frame, const BoxInWorld& box) {
  const auto corners = corners_with_shadow(box, frame.lights.key);
  for (int e = 0; e < frame.views; ++e) {
    const Eye& eye = frame.eyes[static_cast<std::size_t>(e)];
    if (before(eye, corners)) return true;
    const Pose& X_WM = frame.mirror.X_WM;
    if (glass_in(eye, frame.mirror, {1, 1}) && before(reflected(eye, X_WM), corners, before_glass(X_WM))) return true;
  }
  return false;
}

double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across) {
  // Smallest distance from the eye that is used, m, because an eye may be inside the box.
  constexpr double kNearest = 1e-3;
  double least = 1e9;
  for (int e = 0; e < frame.views; ++e) {
    const Eye& eye = frame.eyes[static_cast<std::size_t>(e)];
    const glm::dmat4 clip = eye.projection * eye.view;
    double closest = 1e9;
    for (int corner = 0; corner < 8; ++corner)
      closest = std::min(closest, (clip * glm::dvec4(corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                                                     corner & 4 ? box.hi.z : box.lo.z, 1))
                                      .w);
    // Width that the picture shows at the distance `closest`, m.
    const double wide = 2 * std::max(closest, kNearest) / std::abs(eye.projection[0][0]);
    least = std::min(least, wide / pixels_across);
  }
  return least;
}

}  // namespace typodont::render

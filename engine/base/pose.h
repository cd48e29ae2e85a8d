// Positions and rotations of frames, with names in Drake's convention: X_AB is the pose of frame B as seen from frame
// A. In a product the inner letters are equal: X_AC = X_AB * X_BC, p_AQ = X_AB * p_BQ. The frames are listed in
// ARCHITECTURE.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace typodont {

using glm::dquat;
using glm::dvec3;

/// A rotation and a translation in m, never a reflection (display::EyeView has a flag for mirrors). The type is
/// trivially copyable, so that messages between threads can contain it.
struct Pose {
  dvec3 p{0, 0, 0};     // m, position of the origin of frame B in frame A
  dquat R{1, 0, 0, 0};  // unit quaternion that rotates vectors from B into A

  /// Converts a point from frame B to frame A (m).
  dvec3 operator*(const dvec3& p_BQ) const { return p + R * p_BQ; }
  Pose operator*(const Pose& X_BC) const { return {p + R * X_BC.p, R * X_BC.R}; }
  /// Converts a direction or force from frame B to frame A. It is rotated and not translated.
  dvec3 rotate(const dvec3& v_B) const { return R * v_B; }
};

inline Pose inverse(const Pose& X_AB) {
  const dquat R_BA = glm::conjugate(X_AB.R);
  return {R_BA * -X_AB.p, R_BA};
}

/// Returns the pose between a and b: the position lies on a straight line and the rotation is a slerp. s = 0 gives a,
/// and s = 1 gives b.
inline Pose interpolate(const Pose& a, const Pose& b, double s) {
  return {glm::mix(a.p, b.p, s), glm::slerp(a.R, b.R, s)};
}

/// Returns the shortest rotation that rotates the unit vector `from` into the unit vector `to`.
inline dquat rotation_between(const dvec3& from, const dvec3& to) {
  const double c = glm::dot(from, to);
  if (c < -1.0 + 1e-12) {  // the directions are opposite, so any perpendicular axis is correct
    const dvec3 axis =
        glm::normalize(glm::abs(from.x) < 0.9 ? glm::cross(from, dvec3(1, 0, 0)) : glm::cross(from, dvec3(0, 1, 0)));
    return {0, axis.x, axis.y, axis.z};
  }
  const dvec3 axis = glm::cross(from, to);
  return glm::normalize(dquat(1 + c, axis.x, axis.y, axis.z));
}

/// Returns the angle between the rotations a and b, in rad, from 0 to π.
inline double rotation_angle(const dquat& a, const dquat& b) {
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b))));
}

/// A body's frame moves from pose a to pose b. Returns an upper bound (m) of the distance that any point of the body
/// moves. `reach`: m, largest distance of a point of the body from the frame's origin.
inline double displacement_bound(const Pose& a, const Pose& b, double reach) {
  return glm::length(b.p - a.p) + rotation_angle(a.R, b.R) * reach;
}

/// Returns true if all components of both poses are equal.
inline bool same(const Pose& a, const Pose& b) {
  return a.p == b.p && a.R == b.R;
}

inline bool is_finite(const dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace typodont

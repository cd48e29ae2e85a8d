// Poses in Drake's convention: X_AB is frame B seen from A. Inner letters match: X_AC = X_AB * X_BC, p_AQ = X_AB *
// p_BQ. Frames: ARCHITECTURE.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace typodont {

using glm::dquat;
using glm::dvec3;

/// Rotation and translation (m), never a reflection; for mirrors see display::EyeView. Trivially copyable, for messages
/// between threads.
struct Pose {
  dvec3 p{0, 0, 0};     // m, origin of frame B, seen in frame A
  dquat R{1, 0, 0, 0};  // unit quaternion, rotates vectors from frame B to frame A

  /// Transforms a point from frame B to frame A, m.
  dvec3 operator*(const dvec3& p_BQ) const { return p + R * p_BQ; }
  Pose operator*(const Pose& X_BC) const { return {p + R * X_BC.p, R * X_BC.R}; }
  /// Rotates a vector from frame B to A, without translation.
  dvec3 rotate(const dvec3& v_B) const { return R * v_B; }
};

inline Pose inverse(const Pose& X_AB) {
  const dquat R_BA = glm::conjugate(X_AB.R);
  return {R_BA * -X_AB.p, R_BA};
}

/// Interpolates along a straight line and by slerp. s = 0 gives a, s = 1 gives b.
inline Pose interpolate(const Pose& a, const Pose& b, double s) {
  return {glm::mix(a.p, b.p, s), glm::slerp(a.R, b.R, s)};
}

/// Smallest rotation from unit vector `from` to unit vector `to`.
inline dquat rotation_between(const dvec3& from, const dvec3& to) {
  const double c = glm::dot(from, to);
  if (c < -1.0 + 1e-12) {  // opposite vectors: rotate about any perpendicular axis
    const dvec3 axis =
        glm::normalize(glm::abs(from.x) < 0.9 ? glm::cross(from, dvec3(1, 0, 0)) : glm::cross(from, dvec3(0, 1, 0)));
    return {0, axis.x, axis.y, axis.z};
  }
  const dvec3 axis = glm::cross(from, to);
  return glm::normalize(dquat(1 + c, axis.x, axis.y, axis.z));
}

/// Angle between two orientations, rad, 0 to π.
inline double rotation_angle(const dquat& a, const dquat& b) {
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b))));
}

/// Upper bound of the displacement of any point of a body that moves from a to b, m. `reach`: distance of the body's
/// farthest point from its origin, m.
inline double displacement_bound(const Pose& a, const Pose& b, double reach) {
  return glm::length(b.p - a.p) + rotation_angle(a.R, b.R) * reach;
}

/// True if all components are equal.
inline bool same(const Pose& a, const Pose& b) {
  return a.p == b.p && a.R == b.R;
}

inline bool is_finite(const dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace typodont

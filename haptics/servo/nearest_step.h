// The small motion of a tool, displacement and rotation, that is nearest to a wanted motion on the allowed side of all
// planes: the constrained motion of a god-object with six degrees of freedom (Ortega, Redon & Coquillart 2007).
#pragma once

#include <array>
#include <span>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics {

/// Displacement of the head's centre, m, and rotation vector × a lever, m. The lever makes both comparable: it is the
/// square root of rotational / linear stiffness.
struct PoseStep {
  dvec3 p{0}, r{0};

  PoseStep& operator+=(const PoseStep& other) noexcept { return p += other.p, r += other.r, *this; }
  PoseStep& operator-=(const PoseStep& other) noexcept { return p -= other.p, r -= other.r, *this; }
};
inline PoseStep operator*(double factor, const PoseStep& step) noexcept {
  return {factor * step.p, factor * step.r};
}
inline double dot(const PoseStep& a, const PoseStep& b) noexcept {
  return glm::dot(a.p, b.p) + glm::dot(a.r, b.r);
}

/// Planes near a tool, as bounds of its next motion. Never allocates.
class StepPlanes {
 public:
  /// `lever`: m, see PoseStep. `overlap`: m, overlap that the tool need not leave; it must leave a larger one, but by
  /// at most `led_out` (m) in this step.
  void set(std::span<const NearPlane> planes, double lever, double overlap, double led_out) noexcept;

  /// Computes the allowed motion nearest to `wanted`. `active`: receives the planes that hold the tool, and their
  /// pushes in m: force / linear stiffness. Returns false if there is none; `step` is then undefined.
  bool nearest(const PoseStep& wanted, PoseStep& step, ActivePlanesOf<6>& active) const noexcept;
  /// Computes the displacement nearest to `wanted` that the planes allow if the tool turns by `r` (PoseStep::r).
  /// Returns false if there is none.
  bool nearest_shift(const dvec3& r, const dvec3& wanted, dvec3& shift) const noexcept;

 private:
  struct Bound {
    PoseStep n;
    double room;  // m
  };
  class InPose;
  class InSpace;

  std::array<Bound, kMaxNearPlanes> bounds_;
  int count_ = 0;
};

}  // namespace typodont::haptics

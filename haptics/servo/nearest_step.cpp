#include "haptics/servo/nearest_step.h"

#include <algorithm>

namespace typodont::haptics {

namespace {

// m; a smaller violation of a plane is ignored
constexpr double kStepSlip = 1e-11;
// Small, because the normals of two contacts of one wall differ only by their levers.
constexpr ActiveSetLimits kStepLimits = {.min_pivot = 1e-10, .min_rest = 1e-10};

/// Index of the inactive plane that `at` violates most; -1: none.
template <class Planes, class Vector>
int most_violated(const Planes& planes, int total, const Vector& at, const int* active, int count) noexcept {
  int worst = -1;
  double least = -kStepSlip;
  for (int i = 0; i < total; ++i) {
    const double e = planes.excess(planes.plane(i), at);
    if (e < least && std::find(active, active + count, i) == active + count) worst = i, least = e;
  }
  return worst;
}

}  // namespace

/// The bounds as planes for displacement and rotation.
class StepPlanes::InPose {
 public:
  using Plane = Bound;
  static constexpr ActiveSetLimits kLimits = kStepLimits;

  explicit InPose(const StepPlanes& planes) : planes_(planes) {}

  const Bound& plane(int i) const noexcept { return planes_.bounds_[static_cast<std::size_t>(i)]; }
  double excess(const Bound& bound, const PoseStep& step) const noexcept { return dot(bound.n, step) + bound.room; }
  int worst(const PoseStep& step, const int* active, int count) const noexcept {
    return most_violated(*this, planes_.count_, step, active, count);
  }

 private:
  const StepPlanes& planes_;
};

/// The bounds as planes for the displacement alone, at a given rotation.
class StepPlanes::InSpace {
 public:
  struct Plane {
    dvec3 n;
    double room;
  };
  static constexpr ActiveSetLimits kLimits = kStepLimits;

  InSpace(const StepPlanes& planes, const dvec3& r) : planes_(planes), r_(r) {}

  Plane plane(int i) const noexcept {
    const Bound& bound = planes_.bounds_[static_cast<std::size_t>(i)];
    return {bound.n.p, bound.room + glm::dot(bound.n.r, r_)};
  }
  double excess(const Plane& plane, const dvec3& p) const noexcept { return glm::dot(plane.n, p) + plane.room; }
  int worst(const dvec3& p, const int* active, int count) const noexcept {
    return most_violated(*this, planes_.count_, p, active, count);
  }

 private:
  const StepPlanes& planes_;
  dvec3 r_;
};

void StepPlanes::set(std::span<const NearPlane> planes, double lever, double overlap, double led_out) noexcept {
  count_ = 0;
  for (const NearPlane& plane : planes) {
    bounds_[static_cast<std::size_t>(count_++)] = {
        {plane.n, glm::cross(plane.x, plane.n) / lever},
        plane.gap > 0 ? plane.gap : std::max(std::min(plane.gap + overlap, 0.0), -led_out)};
  }
}

bool StepPlanes::nearest(const PoseStep& wanted, PoseStep& step, ActivePlanesOf<6>& active) const noexcept {
  active.count = 0;
  return ActiveSet<InPose, PoseStep, 6>(InPose(*this)).solve(wanted, step, active);
}

bool StepPlanes::nearest_shift(const dvec3& r, const dvec3& wanted, dvec3& shift) const noexcept {
  ActivePlanes active;
  return ActiveSet(InSpace(*this, r)).solve(wanted, shift, active);
}

}  // namespace typodont::haptics

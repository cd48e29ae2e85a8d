#include "haptics/contact/mesh_lod/plane_set.h"

#include <algorithm>

namespace typodont::haptics::mesh_lod {

namespace {

/// The planes of a PlaneSet for the active-set solver; x is the displacement (m) from the planes' common centre c.
class FacePlanes {
 public:
  using Plane = mesh_lod::Plane;
  // Limits of the solver (ActiveSetLimits). Small, because planes of neighbouring faces may be nearly parallel.
  static constexpr ActiveSetLimits kLimits = {.min_pivot = 1e-10, .min_rest = 1e-10};

  explicit FacePlanes(const PlaneSet& set) : set_(set) {}

  const Plane& plane(int i) const noexcept { return set_[i]; }
  double excess(const Plane& plane, const dvec3& x) const noexcept { return glm::dot(plane.n, x) + plane.gap; }
  int worst(const dvec3& x, const int* active, int count) const noexcept {
    constexpr double kSlip = 1e-13;  // m; a smaller violation of a plane is ignored
    int worst = -1;
    double least = -kSlip;
    for (int i = 0; i < set_.count(); ++i) {
      const double e = excess(set_[i], x);
      const bool worse = e < least || (e == least && worst >= 0 && set_[i].order < set_[worst].order);
      if (worse && std::find(active, active + count, i) == active + count) worst = i, least = e;
    }
    return worst;
  }

 private:
  const PlaneSet& set_;
};

}  // namespace

dvec3 PlaneSet::nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept {
  dvec3 x;
  active.count = 0;
  if (ActiveSet(FacePlanes(*this)).solve(goal, x, active)) return x;
  active.count = 0;
  return dvec3(0);
}

}  // namespace typodont::haptics::mesh_lod

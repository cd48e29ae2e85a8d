#include "calibration/rig_geometry.h"

namespace typodont::calibration {

PanelPoint pixel_for(const RigGeometry& rig, const dvec3& eye, const dvec3& p) {
  std::optional<sight::Mirror<double>> mirror;
  if (rig.mirror) mirror = rig.mirror->shape();
  const auto [u, v] = sight::pixel_through(rig.panel.shape(), mirror ? &*mirror : nullptr, eye, p);
  return {u, v};
}

dvec3 closest_point(const dvec3& left_eye, const dvec3& left_dot, const dvec3& right_eye, const dvec3& right_dot) {
  const auto vec = sight::vec<double>;
  return sight::plain(sight::closest_point(vec(left_eye), vec(left_dot), vec(right_eye), vec(right_dot)));
}

dvec3 perceived(const RigGeometry& believed, const RigGeometry& truth, const dvec3& p) {
  const PanelPoint left = pixel_for(believed, believed.eyes.left_eye(), p);
  const PanelPoint right = pixel_for(believed, believed.eyes.right_eye(), p);
  const dvec3 l = truth.eyes.left_eye(), r = truth.eyes.right_eye();
  return closest_point(l, truth.appears(left.u, left.v, l), r, truth.appears(right.u, right.v, r));
}

}  // namespace typodont::calibration

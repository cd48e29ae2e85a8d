#include "calibration/rig_geometry.h"

namespace typodont::calibration {

PanelPoint pixel_for(const RigGeometry& rig, const dvec3& eye, const dvec3& p) {
  const dvec3 corner = rig.appears(0, 0), u = rig.appears(1, 0) - corner, v = rig.appears(0, 1) - corner;
  const dvec3 normal = glm::cross(u, v);
  const dvec3 ray = p - eye;
  const dvec3 hit = eye + ray * (glm::dot(normal, corner - eye) / glm::dot(normal, ray)) - corner;
  // The axes u and v need not be perpendicular, so two linear equations are solved for the coordinates of `hit`.
  const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), hu = glm::dot(hit, u),
               hv = glm::dot(hit, v);
  const double det = uu * vv - uv * uv;
  return {(hu * vv - hv * uv) / det, (hv * uu - hu * uv) / det};
}

dvec3 closest_point(const dvec3& a, const dvec3& left_dot, const dvec3& b, const dvec3& right_dot) {
  const dvec3 d = glm::normalize(left_dot - a), e = glm::normalize(right_dot - b), w = a - b;
  const double de = glm::dot(d, e), dw = glm::dot(d, w), ew = glm::dot(e, w), det = 1 - de * de;
  const double s = (de * ew - dw) / det, t = (ew - de * dw) / det;
  return 0.5 * (a + s * d + b + t * e);
}

dvec3 perceived(const RigGeometry& believed, const RigGeometry& truth, const dvec3& p) {
  const PanelPoint left = pixel_for(believed, believed.eyes.left_eye(), p);
  const PanelPoint right = pixel_for(believed, believed.eyes.right_eye(), p);
  return closest_point(truth.eyes.left_eye(), truth.appears(left.u, left.v), truth.eyes.right_eye(),
                       truth.appears(right.u, right.v));
}

}  // namespace typodont::calibration

// Geometry of panel, mirror, eyes and haptic base. Metres, world frame W.
#pragma once

#include <optional>

#include "engine/base/line_of_sight.h"
#include "engine/base/pose.h"

namespace typodont::calibration {

/// The display panel. u runs to the right and v upwards in the picture, 0..1.
struct Panel {
  dvec3 lower_left{-0.17, -0.1, 0}, lower_right{0.17, -0.1, 0}, upper_left{-0.17, 0.1, 0};
  dvec3 bow{0, 0, 0};  // m, bend of the panel (sight::Panel)
  dvec3 at(double u, double v) const { return sight::plain(shape().at(u, v)); }
  sight::Panel<double> shape() const {
    using sight::vec;
    return {vec<double>(lower_left), vec<double>(lower_right - lower_left), vec<double>(upper_left - lower_left),
            vec<double>(bow)};
  }
};

/// Plane n·x = offset with unit normal n, which may be slightly curved about its point nearest to `middle`.
struct MirrorPlane {
  dvec3 normal{0, 1, 0};
  double offset = 0;                          // m, distance of the plane from the origin along n
  dvec3 middle{0, 0, 0}, curvature{0, 0, 0};  // m; 1/m (sight::Mirror)
  dvec3 reflect(const dvec3& p) const { return p - 2 * (glm::dot(normal, p) - offset) * normal; }
  sight::Mirror<double> shape() const {
    using sight::vec;
    return sight::Mirror<double>::make(vec<double>(normal), offset, vec<double>(middle), vec<double>(curvature));
  }
};

struct EyePair {
  dvec3 center{0, 0.3, 0.4};
  double ipd = 0.063;
  dvec3 right{1, 0, 0};  // unit vector from the left eye to the right eye
  dvec3 left_eye() const { return center - 0.5 * ipd * right; }
  dvec3 right_eye() const { return center + 0.5 * ipd * right; }
};

struct RigGeometry {
  Panel panel;
  std::optional<MirrorPlane> mirror;
  EyePair eyes;
  Pose X_WH;
  /// Position at which a pixel appears to an eye: behind the mirror, if there is one.
  dvec3 appears(double u, double v, const dvec3& eye) const {
    const dvec3 p = panel.at(u, v);
    if (!mirror) return p;
    if (mirror->curvature == dvec3(0)) return mirror->reflect(p);
    using sight::vec;
    return sight::plain(sight::seen_in(mirror->shape(), vec<double>(eye), vec<double>(p)));
  }
};

struct PanelPoint {
  double u = 0, v = 0;
};

/// Dots on the panel, one for each eye.
struct Dots {
  PanelPoint left, right;
};

/// Pixel through which an eye sees the point p_W.
PanelPoint pixel_for(const RigGeometry& rig, const dvec3& eye_W, const dvec3& p_W);

inline Dots dots_for(const RigGeometry& rig, const dvec3& p_W) {
  return {pixel_for(rig, rig.eyes.left_eye(), p_W), pixel_for(rig, rig.eyes.right_eye(), p_W)};
}

/// Midpoint of the shortest connection between two lines of sight.
dvec3 closest_point(const dvec3& left_eye, const dvec3& left_dot, const dvec3& right_eye, const dvec3& right_dot);

/// Position at which a user sees a point that is drawn at p_W. `believed`: rig that the program assumes. `truth`: the
/// actual rig.
dvec3 perceived(const RigGeometry& believed, const RigGeometry& truth, const dvec3& p_W);

}  // namespace typodont::calibration

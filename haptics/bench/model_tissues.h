// The tissues of `typodont bench models`, each with its exact shape, and the paths of a hand on them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/bench.h"
#include "haptics/bench/reference_contact.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::bench {

inline constexpr double kProbeRadius = 0.6e-3;  // m, radius of the ball that slides, taps and drills
inline constexpr double kHandDepth = 0.3e-3;  // m, distance of the hand below the ball, which stays outside the tissue

/// A tissue on which every contact model is measured.
struct ModelTissue {
  std::string name;
  ExactShape shape;
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start;  // m, initial position of the ball's centre, outside the tissue and less than 2 mm from the surface
  /// Direction of the hand's path along the surface at tick `i`, for a contact at c with unit normal n out of the
  /// tissue. The direction need not be tangential or of unit length.
  std::function<dvec3(int i, const dvec3& c, const dvec3& n)> ahead;
  bool solid = true;                // false: a bur would fall through the tissue
  std::vector<double> voxels_mm{};  // mm, voxel sizes to measure an anatomical tissue with; empty for other tissues
};

/// Analytic tissues: "ball", "torus", "box edges", "thin sheet", "groove".
std::vector<ModelTissue> analytic_tissues();

/// A sheet of 6 × 6 mm; its name is, for example, "sheet of 0.2 mm".
ModelTissue sheet_tissue(double thickness_mm);
/// A tissue given as a mesh, or as a field that is converted to a mesh. The hand starts above `start`, a point on the
/// mesh.
ModelTissue mesh_tissue(const ModelAnatomy& anatomy);

/// The path of a hand, the same for every model, with the exact positions of the ball.
struct Course {
  std::vector<dvec3> hand;   // m
  std::vector<dvec3> truth;  // m, exact centre of the ball outside the tissue; the hand's position if nothing touches
};
struct Slide {
  double radius = kProbeRadius;  // m, radius of the ball
  double depth = kHandDepth;     // m, distance of the hand below the ball
  double speed = 20e-3;          // m/s
};
/// A hand that moves down onto the surface and slides over it.
Course slide_course(const ModelTissue& tissue, int ticks, const Slide& slide = {});
/// A hand that taps on one point. It moves to kHandDepth below the surface and back, at 10, 30, 100 and 200 mm/s.
Course tap_course(const ModelTissue& tissue);

/// Volume of the part of the exact shape that lies within `radius` of any of the segments, m³; counts the points of a
/// grid with spacing `step`.
double swept_volume(const ExactShape& shape, const std::vector<std::pair<dvec3, dvec3>>& segments, double radius,
                    double step);

}  // namespace typodont::haptics::bench

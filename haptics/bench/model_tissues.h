// The tissues of `typodont bench models`, each with its exact shape, and the courses of a hand on them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/bench.h"
#include "haptics/bench/reference_contact.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::bench {

inline constexpr double kProbeRadius = 0.6e-3;  // m, of the ball that slides, taps and drills
inline constexpr double kHandDepth = 0.3e-3;    // m, how far the hand is ahead of the ball that the tissue holds

/// A tissue that every contact model is measured on.
struct ModelTissue {
  std::string name;
  ExactShape shape;
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start;  // m, a place of the ball's centre in the open, less than 2 mm from the surface
  /// Where the hand goes next along the surface: at tick `i`, contact at c, unit normal n out of the tissue. Not
  /// necessarily tangential or of unit length.
  std::function<dvec3(int i, const dvec3& c, const dvec3& n)> ahead;
  bool solid = true;                // a bur sinks into it; false: it would fall through
  std::vector<double> voxels_mm{};  // of an anatomy: the voxels that it is measured with; else empty
};

/// Analytic tissues: "ball", "torus", "box edges", "thin sheet", "groove".
std::vector<ModelTissue> analytic_tissues();

/// A sheet of 6 × 6 mm, "sheet of 0.2 mm".
ModelTissue sheet_tissue(double thickness_mm);
/// A tissue that is a mesh, or whose field was made into one: the hand starts above `start`, which lies on it.
ModelTissue mesh_tissue(const ModelAnatomy& anatomy);

/// A hand that every model gets, tick by tick, and where the ball must be then.
struct Course {
  std::vector<dvec3> hand;   // m
  std::vector<dvec3> truth;  // m, the ball's centre outside the tissue; the hand itself where nothing touches
};
struct Slide {
  double radius = kProbeRadius;  // m, of the ball
  double depth = kHandDepth;     // m, how far the hand is ahead of it
  double speed = 20e-3;          // m/s
};
/// The hand comes down onto the surface and slides over it.
Course slide_course(const ModelTissue& tissue, int ticks, const Slide& slide = {});
/// Taps on one place: in by kHandDepth and out again with 10, 30, 100 and 200 mm/s.
Course tap_course(const ModelTissue& tissue);

/// Volume of the exact shape within `radius` of any of the segments, m³, by counting points on a grid of `step`.
double swept_volume(const ExactShape& shape, const std::vector<std::pair<dvec3, dvec3>>& segments, double radius,
                    double step);

}  // namespace typodont::haptics::bench

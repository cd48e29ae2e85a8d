// The tissues on which contact models are compared, with their exact shapes, and the paths of a hand on them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/tissue_volume.h"
#include "tests/support/reference_contact.h"

namespace typodont::test {

using haptics::TissueVolume;

inline constexpr double kProbeRadius = 0.6e-3;  // m, radius of the ball that slides, taps and drills
// m, distance of the hand below the ball's centre; the ball stays outside the tissue while the hand pulls it inward
inline constexpr double kHandDepth = 0.3e-3;

/// A tissue on which every contact model is measured.
struct ModelTissue {
  std::string name;
  ExactShape shape;
  std::function<TissueVolume(double voxel_mm)> make;
  dvec3 start;  // m, initial position of the ball's centre: outside the tissue, less than 2 mm from the surface
  /// Returns the direction of the hand's path along the surface in tick `i`. The contact is at c, and n is the unit
  /// normal out of the tissue. The direction need not be tangential or of unit length.
  std::function<dvec3(int i, const dvec3& c, const dvec3& n)> ahead;
  bool solid = true;  // true: the tissue is thick; false: it is so thin that a bur would fall through
  // mm, voxel sizes with which an anatomical tissue is measured; empty for other tissues
  std::vector<double> voxels_mm{};
};

/// Returns the tissues with simple shapes: "ball", "torus", "box edges", "thin sheet", "groove".
std::vector<ModelTissue> analytic_tissues();

/// Returns a square sheet. Its name is, for example, "sheet of 0.2 mm".
ModelTissue sheet_tissue(double thickness_mm, double width_mm = 6);
/// Returns a tissue with this exact surface. The hand starts above `start`, a point on the mesh. `make` and
/// `voxels_mm`: as in ModelTissue.
ModelTissue mesh_tissue(const std::string& name, const TissueMesh& mesh, std::function<TissueVolume(double)> make,
                        const dvec3& start, std::vector<double> voxels_mm);

/// The path of a hand, which is the same for every model, and the exact positions of the ball.
struct Course {
  std::vector<dvec3> hand;  // m, position of the hand in each tick
  // m, exact position of the ball's centre, outside the tissue; without contact it is the hand's position
  std::vector<dvec3> truth;
};
struct Slide {
  double radius = kProbeRadius;  // m, radius of the ball
  double depth = kHandDepth;     // m, distance of the hand below the ball's centre
  double speed = 20e-3;          // m/s, speed of the hand
};
/// Returns the path of a hand that moves down onto the surface and slides over it.
Course slide_course(const ModelTissue& tissue, int ticks, const Slide& slide = {});
/// Returns the path of a hand that taps on one point of the surface: at 10, 30, 100 and 200 mm/s, it moves down to the
/// point and back up. At the lowest position of the hand, a ball centred at the hand would sink by kHandDepth into the
/// surface.
Course tap_course(const ModelTissue& tissue);

/// The simulated hand of the drilling test: a mass of 0.15 kg that presses a ball onto the tissue with 1 N and moves it
/// back and forth.
class PressingHand {
 public:
  /// The hand starts 0.02 mm above the surface point nearest to the start of `tissue`.
  explicit PressingHand(const ModelTissue& tissue);

  /// Moves the hand for dt (s). `force` (N) is the tool's force on it. Returns the new position (m).
  const dvec3& next(const dvec3& force, double dt);

  const dvec3& position() const { return x_; }
  const dvec3& normal() const { return n_; }  // unit normal out of the tissue where the hand started
  /// Returns the depth (m) of the hand below its start.
  double depth() const { return glm::dot(rest_ - x_, n_); }

 private:
  dvec3 n_, side_, rest_, x_, v_{0};
  int tick_ = 0;
};

/// Returns the volume, in m³, of the part of the exact shape that lies within `radius` of any segment. It is computed
/// by counting the points of a grid with the spacing `step`.
double swept_volume(const ExactShape& shape, const std::vector<std::pair<dvec3, dvec3>>& segments, double radius,
                    double step);

}  // namespace typodont::test

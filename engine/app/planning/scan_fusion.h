// An intraoral scan that is aligned with the teeth of a cone beam CT. Contains the registration by picked points and by
// surfaces, and the class with which a user picks the points. Frame S is the frame of the scan's file, frame C the
// frame of the CT.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/registration_solver.h"
#include "calibration/surface_solver.h"
#include "engine/app/planning/surface_picture.h"
#include "engine/base/progress.h"
#include "haptics/import/fuse.h"

namespace typodont {

struct ScanRegistration {
  calibration::RegistrationResult start;  // initial registration of the scan, by the points that the user picked
  /// Registration by the surfaces. The solver uses the letter D for the CT's frame, which is frame C in this file. So
  /// the solver's result X_DS is the pose of the scan in the CT's frame, X_CS.
  calibration::SurfaceRegistration fine;
};

/// Registers a scan. A first pose comes from pairs of corresponding points (m), the final pose from the surfaces of the
/// teeth. For messages: `place` states where the pairs come from, and `file` is the name of the scan. Throws Error if
/// the pairs do not give a pose, or if the result cannot be trusted.
ScanRegistration register_scan(const haptics::IntraoralScan& scan, const haptics::DenseTissue& ct,
                               const std::vector<dvec3>& points_S, const std::vector<dvec3>& points_C,
                               const std::string& place, const std::string& file);

/// The surfaces of scan and CT, with the points that the user picks in them. Main thread only, except where a comment
/// names another thread.
class ScanFusion {
 public:
  enum Side : std::size_t { kScan, kCt };
  static constexpr std::size_t kLeastPairs = 3;

  /// Reads the scan, closes its surface, and extracts the CT's surface. For any thread. `unit`: m, length of the unit
  /// in which the file states coordinates. Throws Error.
  ScanFusion(std::shared_ptr<const haptics::DenseTissue> ct, const std::filesystem::path& file, double unit);

  SurfacePicture& view(Side side) { return views_[side]; }
  const SurfacePicture& view(Side side) const { return views_[side]; }
  const std::vector<dvec3>& points(Side side) const { return points_[side]; }
  /// Adds a point that the user picked. `side`: picture in which the point was picked (scan or CT); `place`: position
  /// in the last picture of this side. Returns false if there is no surface at this position, or if the next point must
  /// be picked in the other picture.
  bool pick(Side side, const dvec2& place);
  void drop_last();  // removes the point that the user picked last
  bool can_register() const {
    return points_[kScan].size() >= kLeastPairs && points_[kScan].size() == points_[kCt].size();
  }

  /// Registers the scan by points and surfaces. For any thread, while no other call changes this object. Throws Error.
  ScanRegistration registered() const;
  /// Shows a registration: the scan over the CT, coloured by the distance between them. Picking another point discards
  /// the registration.
  void show(ScanRegistration registration);
  const std::optional<ScanRegistration>& registration() const { return registration_; }
  /// Replaces the CT's crowns by the scan. Requires a registration. For any thread, while no other call changes this
  /// object. Throws Error or Cancelled.
  haptics::Fused fused(Progress& progress) const;

 private:
  void show_ct();

  std::shared_ptr<const haptics::DenseTissue> ct_;
  std::string name_;
  haptics::IntraoralScan scan_;
  haptics::TissueMesh scan_mesh_;  // mesh of the scan, in frame S
  haptics::TissueMesh ct_mesh_;    // mesh of the CT's surface, in frame C
  std::vector<glm::vec3> ct_colors_;
  std::array<SurfacePicture, 2> views_;
  std::array<std::vector<dvec3>, 2> points_;
  std::vector<Side> order_;  // the side of each picked point, in the order of picking
  std::optional<ScanRegistration> registration_;
};

}  // namespace typodont

// Registers an intraoral scan (frame S) to the teeth of a cone beam CT (frame C), with points that the user picks.
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
  calibration::RegistrationResult start;  // registration by the picked points
  /// Registration of the surfaces. The member X_DS is the pose of the scan (frame S) in the CT (frame C).
  calibration::SurfaceRegistration fine;
  SurfacePicture picture;  // only from ScanFusion::registered(): both surfaces, in colours of distance
};

/// Registers the scan first by pairs of points (m), then by the surfaces. `place`, `file`: names for error messages.
/// Throws Error if no reliable pose is found.
ScanRegistration register_scan(const haptics::IntraoralScan& scan, const haptics::DenseTissue& ct,
                               const std::vector<dvec3>& points_S, const std::vector<dvec3>& points_C,
                               const std::string& place, const std::string& file);

/// Holds the surfaces of the scan and of the CT, and the points picked on them. Main thread, unless stated otherwise.
class ScanFusion {
 public:
  enum Side : std::size_t { kScan, kCt };
  static constexpr std::size_t kMinPairs = 3;

  /// Closes the scan's mesh, and extracts the CT's surface. Any thread. `unit`: unit of the mesh, m. Throws Error.
  ScanFusion(std::shared_ptr<const haptics::DenseTissue> ct, const std::filesystem::path& file, double unit);

  SurfacePicture& view(Side side) { return views_[side]; }
  const SurfacePicture& view(Side side) const { return views_[side]; }
  const std::vector<dvec3>& points(Side side) const { return points_[side]; }
  /// Picks the point at `place` in the last picture of `side`. False: no surface there, or a point in the other picture
  /// must come next.
  bool pick(Side side, const dvec2& place);
  void drop_last();  // removes the point that the user picked last
  bool can_register() const {
    return points_[kScan].size() >= kMinPairs && points_[kScan].size() == points_[kCt].size();
  }

  /// The registration by the picked points. Any thread, while nothing else changes this object. Throws Error.
  ScanRegistration registered() const;
  /// Shows a registration in colours of distance. Picking another point discards it.
  void show(ScanRegistration registration);
  const std::optional<ScanRegistration>& registration() const { return registration_; }
  /// The CT with the crowns of the scan; needs a registration. Any thread, while nothing else changes this object.
  /// Throws Error or Cancelled.
  haptics::Fused fused(Progress& progress) const;

 private:
  void show_ct(const SurfacePicture& surfaces);

  std::shared_ptr<const haptics::DenseTissue> ct_;
  std::string name_;
  haptics::IntraoralScan scan_;
  haptics::TissueMesh scan_mesh_;  // mesh of the scan, in frame S
  SurfacePicture ct_picture_;      // the CT's surface alone, in frame C
  std::array<SurfacePicture, 2> views_;
  std::array<std::vector<dvec3>, 2> points_;
  std::vector<Side> order_;  // each picked point's side, in the order of picking
  std::optional<ScanRegistration> registration_;
};

}  // namespace typodont

// An intraoral scan laid over the teeth of a cone beam CT: registration from picked points and by surfaces, and the
// session in which a user picks these points. Frame S is that of the scan's file, frame C that of the CT.
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
  calibration::RegistrationResult start;  // from the picked points
  calibration::SurfaceRegistration fine;  // X_DS is X_CS
};

/// Registers a scan from pairs of the same points, m, then by the surfaces of the teeth. `place`: origin of the pairs,
/// and `file`: name of the scan, for messages. Throws Error if the pairs do not give a pose, or if the result cannot be
/// trusted.
ScanRegistration register_scan(const haptics::IntraoralScan& scan, const haptics::DenseTissue& ct,
                               const std::vector<dvec3>& points_S, const std::vector<dvec3>& points_C,
                               const std::string& place, const std::string& file);

/// Both surfaces with the points that the user picks in them. Main thread, except where it says so.
class ScanFusion {
 public:
  enum Side : std::size_t { kScan, kCt };
  static constexpr std::size_t kLeastPairs = 3;

  /// Reads and closes the scan, and extracts the CT's surface. Any thread. `unit`: m per unit of the file. Throws
  /// Error.
  ScanFusion(std::shared_ptr<const haptics::DenseTissue> ct, const std::filesystem::path& file, double unit);

  SurfacePicture& view(Side side) { return views_[side]; }
  const SurfacePicture& view(Side side) const { return views_[side]; }
  const std::vector<dvec3>& points(Side side) const { return points_[side]; }
  /// Adds the point at a place of the view's last picture. False beside the surface, or if the other side lacks points.
  bool pick(Side side, const dvec2& place);
  void drop_last();  // removes the latest point
  bool can_register() const {
    return points_[kScan].size() >= kLeastPairs && points_[kScan].size() == points_[kCt].size();
  }

  /// Computes the registration of the picked points. Any thread, while nothing else changes. Throws Error.
  ScanRegistration registered() const;
  /// Shows a registration: the scan over the CT, in colours of the distance between both. Picking a point discards it.
  void show(ScanRegistration registration);
  const std::optional<ScanRegistration>& registration() const { return registration_; }
  /// Replaces the CT's crowns. Needs a registration. Any thread, while nothing else changes. Throws Error, Cancelled.
  haptics::Fused fused(Progress& progress) const;

 private:
  void show_ct();

  std::shared_ptr<const haptics::DenseTissue> ct_;
  std::string name_;
  haptics::IntraoralScan scan_;
  haptics::TissueMesh scan_mesh_;  // in S
  haptics::TissueMesh ct_mesh_;    // in C
  std::vector<glm::vec3> ct_colors_;
  std::array<SurfacePicture, 2> views_;
  std::array<std::vector<dvec3>, 2> points_;
  std::vector<Side> order_;  // sides in the order of the picks
  std::optional<ScanRegistration> registration_;
};

}  // namespace typodont

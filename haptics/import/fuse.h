// Combines an intraoral scan with a cone beam CT. The scan gives sharp crowns, and the CT gives roots, bone and canals.
// Frame S is the frame of the scan's file, and frame C that of the CT's volume. Not real-time; throws Error.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics {

namespace importing {
struct ArchSurface;
}

/// A point on a scan's surface.
struct ScanPoint {
  dvec3 p_S;  // m, position of the point in frame S of the scan
  dvec3 n_S;  // unit normal of the surface in frame S, pointing outward
};

/// Returns the area (m²) of a mesh.
double area_of(const TissueMesh& mesh);
/// Returns points that are spread evenly over a mesh. Each point represents the area area_of(mesh) / count.
std::vector<ScanPoint> spread_points(const TissueMesh& mesh, std::size_t count);

/// The surface of an intraoral scan (STL, PLY, OBJ, glTF), which may be open. It is repaired and closed by a base, as
/// in `import --preset arch`.
class IntraoralScan {
 public:
  /// Reads the scan. `unit` is the length in m of one unit of the file.
  IntraoralScan(const std::filesystem::path& file, double unit);
  ~IntraoralScan();
  IntraoralScan(IntraoralScan&&) noexcept;

  /// Returns points that are spread evenly over the scanned surface, without the base. Each point represents the area
  /// area() / count.
  std::vector<ScanPoint> points(std::size_t count) const;
  double area() const { return area_; }  // m², area of the scanned surface
  /// Returns the scanned surface without the base, in frame S of the scan.
  TissueMesh mesh() const;
  /// Returns the unit vector (in frame S of the scan) from the scan's border or base towards the teeth; zero if it is
  /// unknown.
  const dvec3& up() const;
  const std::vector<std::string>& repairs() const;
  const importing::ArchSurface& surface() const { return *surface_; }

 private:
  std::unique_ptr<importing::ArchSurface> surface_;
  double area_ = 0;
};

/// Finds the surface of the teeth in a CT's volume, for registration. The object keeps a reference to the volume, so
/// the volume must exist longer than the object.
class ToothField {
 public:
  explicit ToothField(const DenseTissue& ct) : ct_(ct) {}
  struct Value {
    // true if the nearest surface is near enough that the CT stores its distance, and belongs to a tooth or a
    // restoration
    bool tooth = false;
    double distance = 0;  // m, distance to the surface, negative inside
    dvec3 gradient{0};    // gradient of the distance (m per m); on the surface, its direction is the outward normal
  };
  Value at(const dvec3& p_C) const;

 private:
  const DenseTissue& ct_;
};

struct FuseOptions {
  std::optional<double> voxel;  // m, voxel edge of the result; if not given, the voxel edge of the CT
  // m; a part of the scan's surface counts as crown only if it is at most this far from the CT's surface
  double reach = 1e-3;
  // m, width of the transition inside the rim of the crowns: at the rim, the surface is that of the CT; at this
  // distance from the rim, it is that of the scan
  double blend = 0.5e-3;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

struct FuseReport {
  double scanned_area = 0;  // m², area of the scanned surface
  double covered_area = 0;  // m², area of the part of the scan that replaces the CT's surface
  // Statistics of the part of the scan that replaces the CT's surface. At each point of this part, the distance from
  // the CT's surface is measured (m, positive outside). `mean` is the mean of the distances; median_size and most_size
  // are the median and the 95th percentile of their absolute values.
  double mean = 0, median_size = 0, most_size = 0;
};

struct Fused {
  DenseTissue tissue;
  FuseReport report;
};

/// Replaces the surface of the CT's crowns by the scan's surface. The rules are:
/// - A triangle of the scan shows a crown if its corners lie within `reach` of the surface of a tooth in the CT, and
///   the angle between the normals of scan and CT is at most 45°. A gap between such triangles also counts as crown if
///   it is smaller than 10 mm² and does not touch the scan's border (a fissure that the CT does not show). A connected
///   piece of such triangles that is smaller than 5 mm² does not count (gingiva that crosses the CT's surface).
/// - A sample gets the distance to the scan if three conditions hold: the sample's nearest point on the scan shows a
///   crown; the scan lies within `reach` of the sample's nearest point on the CT's surface; both surfaces face the same
///   direction. The sign of the distance comes from the winding number of the closed scan. Within `blend` of the
///   crowns' rim, the sample gets a blend of its distances to the scan and to the CT's surface.
/// - Labels and hardness are those of the CT. If a sample was outside the CT's tissue, its label and hardness are those
///   of the nearest tissue.
/// - If the result has the CT's voxel size, samples that are farther from the changed surface than the band and two
///   voxels keep the CT's distance and label exactly.
///
/// Throws Error if no part of the scan shows a crown, or if the result does not fit into memory.
Fused fuse(const DenseTissue& ct, const IntraoralScan& scan, const Pose& X_CS, const FuseOptions& options);

}  // namespace typodont::haptics

// Crowns of an intraoral scan (frame S) in a cone beam CT (frame C). Not for real time; throws Error.
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
  dvec3 p_S;  // m, frame S
  dvec3 n_S;  // unit normal of the surface in frame S, pointing outward
};

/// Returns the area (m²) of a mesh.
double area_of(const TissueMesh& mesh);
/// Evenly spread; each stands for area_of(mesh) / count.
std::vector<ScanPoint> spread_points(const TissueMesh& mesh, std::size_t count);

/// May be open; repaired and closed as by `import --preset arch`.
class IntraoralScan {
 public:
  /// `unit`: m per unit of the file.
  IntraoralScan(const std::filesystem::path& file, double unit);
  ~IntraoralScan();
  IntraoralScan(IntraoralScan&&) noexcept;

  /// Without the base; each stands for area() / count.
  std::vector<ScanPoint> points(std::size_t count) const;
  double area() const { return area_; }  // m², area of the scanned surface
  /// Without the base, frame S.
  TissueMesh mesh() const;
  /// From border or base to the teeth, frame S; zero: unknown.
  const dvec3& up() const;
  const std::vector<std::string>& repairs() const;
  const importing::ArchSurface& surface() const { return *surface_; }

 private:
  std::unique_ptr<importing::ArchSurface> surface_;
  double area_ = 0;
};

/// Teeth in a CT, for registration. `ct` must outlive it.
class ToothField {
 public:
  explicit ToothField(const DenseTissue& ct) : ct_(ct) {}
  struct Value {
    // within the CT's band, of a tooth or restoration
    bool tooth = false;
    double distance = 0;  // m, distance to the surface, negative inside
    dvec3 gradient{0};    // m per m, outward normal on the surface
  };
  Value at(const dvec3& p_C) const;

 private:
  const DenseTissue& ct_;
};

struct FuseOptions {
  std::optional<double> voxel;  // m; empty: the CT's
  // m, largest distance of a crown from the CT
  double reach = 1e-3;
  // m, from the CT's surface at the rim to the scan's
  double blend = 0.5e-3;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

struct FuseReport {
  double scanned_area = 0;  // m², area of the scanned surface
  double covered_area = 0;  // m², of the scan that replaces the CT
  // m, of the replacing part from the CT, positive outside: mean; median and 95 % of the absolute value
  double mean = 0, median_size = 0, most_size = 0;
};

struct Fused {
  DenseTissue tissue;
  FuseReport report;
};

/// Rules:
/// - Crown: corners within `reach` of a tooth in the CT, normals within 45°. Enclosed gaps below 10 mm² (fissures) too,
///   pieces below 5 mm² (gingiva) not.
/// - A sample takes the distance to the scan if its nearest point there is crown, lies within `reach` of its nearest
///   CT point, and both face alike. Sign: winding number. Within `blend` of the rim: blended.
/// - Labels and hardness: the CT's, outside those of the nearest tissue.
/// - At the CT's voxel size, samples beyond band + two voxels of the change stay exact.
///
/// Throws Error without a crown, or if it does not fit into memory.
Fused fuse(const DenseTissue& ct, const IntraoralScan& scan, const Pose& X_CS, const FuseOptions& options);

}  // namespace typodont::haptics

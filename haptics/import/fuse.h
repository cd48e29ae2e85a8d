// Replaces the crowns in a cone beam CT (frame C) by those of an intraoral scan (frame S). Not for real time; throws
// Error.
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
  dvec3 n_S;  // unit normal of the surface in the scan's frame S, pointing outward
};

/// Returns the area (m²) of a mesh.
double area_of(const TissueMesh& mesh);
/// Distributes points evenly over a mesh; each represents the area area_of(mesh) / count.
std::vector<ScanPoint> spread_points(const TissueMesh& mesh, std::size_t count);

/// The surface of an intraoral scan. It may be open; it is repaired and closed as by `import --preset arch`.
class IntraoralScan {
 public:
  /// `unit`: m per unit of the file.
  IntraoralScan(const std::filesystem::path& file, double unit);
  ~IntraoralScan();
  IntraoralScan(IntraoralScan&&) noexcept;

  /// Points on the scanned surface, without the base; each represents the area area() / count.
  std::vector<ScanPoint> points(std::size_t count) const;
  double area() const { return area_; }  // m², area of the scanned surface
  /// The scanned surface without the base, in the scan's frame S.
  TissueMesh mesh() const;
  /// Direction from the border or base to the teeth, in the scan's frame S; zero if unknown.
  const dvec3& up() const;
  const std::vector<std::string>& repairs() const;
  const importing::ArchSurface& surface() const { return *surface_; }

 private:
  std::unique_ptr<importing::ArchSurface> surface_;
  double area_ = 0;
};

/// Distance field of the teeth in a CT, for registration. `ct` must outlive it.
class ToothField {
 public:
  explicit ToothField(const DenseTissue& ct) : ct_(ct) {}
  struct Value {
    // The nearest surface is within the CT's band, and belongs to a tooth or restoration.
    bool tooth = false;
    double distance = 0;  // m, distance to the surface, negative inside
    dvec3 gradient{0};    // m per m; on the surface, the outward normal
  };
  Value at(const dvec3& p_C) const;

 private:
  const DenseTissue& ct_;
};

struct FuseOptions {
  std::optional<double> voxel;  // m, voxel edge of the fused volume; empty: as the CT
  // Largest distance of a crown from the surface in the CT, m.
  double reach = 1e-3;
  // Width of the transition from the CT's surface at the rim to the scan's surface, m.
  double blend = 0.5e-3;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

struct FuseReport {
  double scanned_area = 0;  // m², area of the scanned surface
  double covered_area = 0;  // m², area of the scan that replaces the CT's surface
  // Distances of the crowns' new surface from the CT's surface, m: mean (positive outside); median and 95 % quantile of
  // the absolute value.
  double mean = 0, median_size = 0, max_size = 0;
};

struct Fused {
  DenseTissue tissue;
  FuseReport report;
};

/// Fuses by these rules:
/// - Crown: triangles whose corners lie within `reach` of a tooth in the CT, with normals within 45°. Enclosed gaps
/// below 10 mm² (fissures) count as crown, pieces below 5 mm² (gingiva) do not.
/// - A sample takes the distance to the scan if its nearest point on the scan is crown and lies within `reach` of its
/// nearest point on the CT's surface, and both surfaces face the same direction. The winding number gives the sign.
/// Within `blend` of the crown's rim, the distances to scan and CT are blended.
/// - Labels and hardness come from the CT; outside the CT's tissue, from its nearest tissue.
/// - At the CT's voxel size, samples farther than band + two voxels from the change keep their exact values.
///
/// Throws Error if no crown is found, or if memory is too small.
Fused fuse(const DenseTissue& ct, const IntraoralScan& scan, const Pose& X_CS, const FuseOptions& options);

}  // namespace typodont::haptics

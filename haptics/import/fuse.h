// Fusion of an intraoral scan with a cone beam CT: the scan gives sharp crowns; the CT gives roots, bone and canals.
// Frame S is that of the scan's file, frame C that of the CT's volume. Set-up time; throws Error.
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

/// A point of a scan's surface.
struct ScanPoint {
  dvec3 p_S;  // m
  dvec3 n_S;  // unit, outward
};

/// The surface of an intraoral scan (STL, PLY, OBJ, glTF), which may be open. It is repaired and closed by a base as in
/// `import --preset arch`.
class IntraoralScan {
 public:
  /// `unit`: m per unit of the file.
  IntraoralScan(const std::filesystem::path& file, double unit);
  ~IntraoralScan();
  IntraoralScan(IntraoralScan&&) noexcept;

  /// Points spread evenly over the scanned surface, without the base. Each point represents the area area() / count.
  std::vector<ScanPoint> points(std::size_t count) const;
  double area() const { return area_; }  // m², of the scanned surface
  /// The scanned surface without the base, in S.
  TissueMesh mesh() const;
  const std::vector<std::string>& repairs() const;
  const importing::ArchSurface& surface() const { return *surface_; }

 private:
  std::unique_ptr<importing::ArchSurface> surface_;
  double area_ = 0;
};

/// The surface of the teeth in a CT's volume, for registration. Keeps a reference to the volume.
class ToothField {
 public:
  explicit ToothField(const DenseTissue& ct) : ct_(ct) {}
  struct Value {
    bool tooth = false;   // the nearest surface is closer than the band and belongs to a tooth or a restoration
    double distance = 0;  // m, negative inside
    dvec3 gradient{0};    // per m
  };
  Value at(const dvec3& p_C) const;

 private:
  const DenseTissue& ct_;
};

struct FuseOptions {
  std::optional<double> voxel;  // m, voxel of the result; default: voxel of the CT
  double reach = 1e-3;          // m, largest distance between scan and CT at which the scan shows a crown of the CT
  double blend = 0.5e-3;        // m, width of the transition from the CT to the scan, inward from the rim of the crowns
  std::function<void(double)> progress;  // 0..1, may be empty
};

struct FuseReport {
  double scanned_area = 0;  // m², area of the scan
  double covered_area = 0;  // m², area of the part that replaces the CT's surface
  // Signed distances from the scan to the CT's surface over this part; positive if the scan lies outside.
  // m: mean of the signed values; median and 95th percentile of the absolute values
  double mean = 0, median_size = 0, most_size = 0;
};

struct Fused {
  DenseTissue tissue;
  FuseReport report;
};

/// Replaces the surface of the CT's crowns by the scan's surface. Rules:
/// - A triangle shows a crown if its corners lie within `reach` of the surface of a tooth in the CT, and the normals
///   agree within 45°. Gaps in this part that are smaller than 10 mm² and do not reach the scan's border also count
/// as crown
///   (a fissure that the CT does not resolve); pieces smaller than 5 mm² do not (gingiva that crosses the CT's
///   surface).
/// - A sample takes the scan's distance if its nearest point on the scan lies in this part, and the scan there lies
///   within `reach` of the sample's nearest point on the CT's surface and faces the same way. The sign is the winding
///   number of the closed scan. Over `blend` from the rim, both distances are blended.
/// - Labels and hardness are those of the CT. A sample that was outside the CT's tissue takes those of the nearest
///   tissue.
/// - Farther than the band and two voxels from the moved surface, samples keep the CT's distance and label exactly,
/// if
///   the voxel is the CT's. Throws Error if no part of the scan shows a crown, or if the result does not fit into
/// memory.
Fused fuse(const DenseTissue& ct, const IntraoralScan& scan, const Pose& X_CS, const FuseOptions& options);

}  // namespace typodont::haptics

// One import function for each kind of input. import_tissue() selects one and completes the imported volume.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"
#include "haptics/import/jaw.h"
#include "haptics/import/levels.h"
#include "haptics/import/scan.h"
#include "haptics/import/shading.h"

namespace typodont::haptics::importing {

/// Grey values of a scan, with notes for the user.
struct ScanGreys {
  Levels levels;
  JawGreys jaw;  // valid only for a jaw
  // Uneven brightness (shading) that was removed from a jaw's scan before its grey values were found.
  std::optional<Shading> shading;
  std::vector<std::string> notes;
};
ScanGreys find_greys(const std::filesystem::path& file, Scan scan, const ImportOptions& options);

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
/// Imports options.region, or all, of a scan in memory. `greys`: grey values of the whole scan, because a region may
/// lack some tissues. `file`: name for messages.
Imported import_region(const std::filesystem::path& file, const Scan& scan, const ScanGreys& greys,
                       const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);
/// Imports an intraoral scan.
Imported import_arch(const std::filesystem::path& file, const ImportOptions& options);
/// Imports the meshes in options.parts, which must not be empty.
Imported import_parts(const ImportOptions& options);

/// Voxels outside the surface get labels up to this distance from it; voxels.
inline constexpr double kLabelReach = 2.5;

/// Returns the smallest box that contains both boxes.
inline ImportRegion around(const ImportRegion& a, const ImportRegion& b) {
  return {glm::min(a.lo, b.lo), glm::max(a.hi, b.hi)};
}
/// Bounding box of a mesh in the frame of the imported volume.
ImportRegion mesh_bounds(const std::filesystem::path& file, const ImportOptions& options);
/// Returns options.voxel; if empty, 0.1 mm, or the smallest larger multiple of 0.01 mm that fits, with a note. Throws
/// Error for too many voxels, or a box longer than a metre.
double voxel_of_meshes(const ImportRegion& bounds, const ImportOptions& options, std::vector<std::string>& notes);

/// Returns true if the number of voxels is allowed. `extent`, `voxel`: m.
bool result_size_fits(const dvec3& extent, double voxel);
/// Throws Error for too many voxels. `extent`, `voxel`: m.
void check_result_size(const dvec3& extent, double voxel);

/// Bytes that can still be allocated: the smaller of the free memory and what is left of the process's limit.
double free_memory();
/// Throws Error if `bytes` exceeds options.memory or the free memory. Keeps the largest value in report.memory.
void require_memory(double bytes, const ImportOptions& options, ImportReport& report);

/// Fills in the report: each tissue's volume, the tooth's height, the part of the crown that is dentin by mistake.
void measure(Imported& imported, ImportPreset preset);
/// Measures and rotates the imported volume: last step of every import.
Imported completed(Imported imported, const ImportOptions& options);

}  // namespace typodont::haptics::importing

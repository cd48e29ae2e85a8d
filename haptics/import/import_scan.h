// One kind of input each; import_tissue() completes.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"
#include "haptics/import/jaw.h"
#include "haptics/import/levels.h"
#include "haptics/import/scan.h"
#include "haptics/import/shading.h"

namespace typodont::haptics::importing {

/// With notes for the user.
struct ScanGreys {
  Levels levels;
  JawGreys jaw;  // valid only for a jaw
  // of a jaw, removed first
  std::optional<Shading> shading;
  std::vector<std::string> notes;
};
ScanGreys find_greys(const std::filesystem::path& file, Scan scan, const ImportOptions& options);

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
/// options.region or all of a scan in memory, with the whole scan's `greys`: a region may lack some. `file`: for
/// messages.
Imported import_region(const std::filesystem::path& file, const Scan& scan, const ScanGreys& greys,
                       const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);
/// Imports an intraoral scan.
Imported import_arch(const std::filesystem::path& file, const ImportOptions& options);
/// Imports the meshes in options.parts, which must not be empty.
Imported import_parts(const ImportOptions& options);

/// voxels outside the surface with labels
inline constexpr double kLabelReach = 2.5;

/// Returns the smallest box that contains both boxes.
inline ImportRegion around(const ImportRegion& a, const ImportRegion& b) {
  return {glm::min(a.lo, b.lo), glm::max(a.hi, b.hi)};
}
/// In the result's frame.
ImportRegion mesh_bounds(const std::filesystem::path& file, const ImportOptions& options);
/// options.voxel, or 0.1 mm, or the smallest larger step of 0.01 mm that fits, with a note. Throws Error for too many
/// voxels, or a box above a metre.
double voxel_of_meshes(const ImportRegion& bounds, const ImportOptions& options, std::vector<std::string>& notes);

/// `extent`, `voxel` in m.
bool result_size_fits(const dvec3& extent, double voxel);
/// Throws Error for too many voxels. `extent`, `voxel` in m.
void check_result_size(const dvec3& extent, double voxel);

/// bytes, also within a limit of the process.
double free_memory();
/// Throws Error above options.memory or the free memory. Keeps the largest in report.memory.
void require_memory(double bytes, const ImportOptions& options, ImportReport& report);

/// Volumes, height and false dentin of the report.
void measure(Imported& imported, ImportPreset preset);
/// Measures and turns: the end of every import.
Imported completed(Imported imported, const ImportOptions& options);

}  // namespace typodont::haptics::importing

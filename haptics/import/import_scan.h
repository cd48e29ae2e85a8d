// Functions that import one kind of input each. import_tissue() completes their results.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"
#include "haptics/import/jaw.h"
#include "haptics/import/levels.h"
#include "haptics/import/scan.h"
#include "haptics/import/shading.h"

namespace typodont::haptics::importing {

/// The grey values of a scan's tissues, and notes for the user about them.
struct ScanGreys {
  Levels levels;
  JawGreys jaw;  // valid only for a jaw
  // error of the grey values of a jaw's scan that changes slowly across the scan; removed before the grey values were
  // found
  std::optional<Shading> shading;
  std::vector<std::string> notes;
};
ScanGreys find_greys(const std::filesystem::path& file, Scan scan, const ImportOptions& options);

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
/// Imports options.region of a scan in memory, or the whole scan if the options have no region. `greys` are the grey
/// values of the tissues in the whole scan, because a small region may lack a tissue or the surroundings. `file` is the
/// name for messages.
Imported import_region(const std::filesystem::path& file, const Scan& scan, const ScanGreys& greys,
                       const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);
/// Imports an intraoral scan.
Imported import_arch(const std::filesystem::path& file, const ImportOptions& options);
/// Imports the meshes in options.parts, which must not be empty.
Imported import_parts(const ImportOptions& options);

/// voxels, distance outside the surface up to which samples get labels
inline constexpr double kLabelReach = 2.5;

/// Returns the smallest box that contains both boxes.
inline ImportRegion around(const ImportRegion& a, const ImportRegion& b) {
  return {glm::min(a.lo, b.lo), glm::max(a.hi, b.hi)};
}
/// Returns the bounding box of the closed mesh that the import of `file` uses, in the frame of the result.
ImportRegion mesh_bounds(const std::filesystem::path& file, const ImportOptions& options);
/// Returns the voxel edge (m) for a volume of meshes with the bounding box `bounds`. It is options.voxel, or 0.1 mm if
/// the user states none. If 0.1 mm would need too many voxels, it is the smallest larger edge that does not, in steps
/// of 0.01 mm, and a note states it. Throws Error if options.voxel needs too many voxels, or if the box is longer than
/// a metre.
double voxel_of_meshes(const ImportRegion& bounds, const ImportOptions& options, std::vector<std::string>& notes);

/// Returns true if a grid that covers `extent` (m) with voxels of the edge `voxel` (m) has an allowed number of voxels.
bool result_size_fits(const dvec3& extent, double voxel);
/// Throws Error if a grid that covers `extent` (m) with voxels of the edge `voxel` (m) has too many voxels.
void check_result_size(const dvec3& extent, double voxel);

/// Returns the number of bytes that this process can still allocate. It is the free memory of the machine, or less if
/// the process has a memory limit.
double free_memory();
/// Throws Error if `bytes` is more than options.memory or, if this option is not given, than the free memory. Stores
/// the largest `bytes` of all calls in report.memory.
void require_memory(double bytes, const ImportOptions& options, ImportReport& report);

/// Computes the volumes, the height and the fraction of false dentin from `imported.tissue`, and stores them in the
/// report.
void measure(Imported& imported, ImportPreset preset);
/// Measures the tissue and rotates it. These are the last steps of every import.
Imported completed(Imported imported, const ImportOptions& options);

}  // namespace typodont::haptics::importing

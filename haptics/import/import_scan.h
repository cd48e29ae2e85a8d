// The import functions, one per kind of input; each fills in everything except what import_tissue() adds.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"
#include "haptics/import/jaw.h"
#include "haptics/import/levels.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// The grey values of a scan's tissues, and notes about them.
struct ScanGreys {
  Levels levels;
  JawGreys jaw;  // only for a jaw
  std::vector<std::string> notes;
};
ScanGreys find_greys(const std::filesystem::path& file, const Scan& scan, const ImportOptions& options);

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
/// Imports options.region of a scan in memory, or all of it. `greys`: those of the whole scan, because a small region
/// may lack a tissue or the surroundings. `file`: for messages.
Imported import_region(const std::filesystem::path& file, const Scan& scan, const ScanGreys& greys,
                       const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);
/// Imports an intraoral scan.
Imported import_arch(const std::filesystem::path& file, const ImportOptions& options);
/// Imports options.parts, which must not be empty.
Imported import_parts(const ImportOptions& options);

/// voxels; distance outside the surface up to which labels are assigned.
inline constexpr double kLabelReach = 2.5;

/// Throws Error if a grid that covers `extent` (m) with voxels of `voxel` (m) does not fit into memory.
void check_result_size(const dvec3& extent, double voxel);

/// Bytes that this process can still allocate: the free memory of the machine, or less if the process is limited.
double free_memory();
/// Throws Error if `bytes` exceed options.memory or, without this option, the free memory. Stores the largest `bytes`
/// of all calls in report.memory.
void require_memory(double bytes, const ImportOptions& options, ImportReport& report);

/// Computes volumes, height and the fraction of false dentin from `imported.tissue`.
void measure(Imported& imported, ImportPreset preset);
/// Measures the tissue and turns it, as the last steps of every import.
Imported completed(Imported imported, const ImportOptions& options);

}  // namespace typodont::haptics::importing

// The ways to tissue, one per kind of input; each fills in everything but what import_tissue adds.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"

namespace typodont::haptics::importing {

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);
/// Of an intraoral scan.
Imported import_arch(const std::filesystem::path& file, const ImportOptions& options);
/// Of options.parts, which there are.
Imported import_parts(const ImportOptions& options);

/// Voxels: how far outside the surface labels are told.
inline constexpr double kLabelReach = 2.5;

/// An Error when a grid of this many voxels is asked for that does not fit into memory.
void check_result_size(const dvec3& extent, double voxel);

/// Bytes that this process may still take: what the machine has free, or less where the process is limited.
double free_memory();
/// An Error where `bytes` are more than options.memory, or than are free. Notes the most in the report.
void require_memory(double bytes, const ImportOptions& options, ImportReport& report);

/// Volumes, height and the share of false dentin, from what is in `imported.tissue`.
void measure(Imported& imported, ImportPreset preset);

}  // namespace typodont::haptics::importing

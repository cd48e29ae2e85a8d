// The two ways to tissue, one per kind of input; each fills in everything but what import_tissue adds.
#pragma once

#include "haptics/import/distance.h"
#include "haptics/import/import.h"

namespace typodont::haptics::importing {

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options);
Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options);

/// An Error when a grid of this many voxels is asked for that does not fit into memory.
void check_result_size(const dvec3& extent, double voxel);

/// Volumes, height and the share of false dentin, from what is in `imported.tissue`.
void measure(Imported& imported, ImportPreset preset);

}  // namespace typodont::haptics::importing

// Imports a label map, whose voxels state their tissue.
#pragma once

#include "haptics/import/import.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// Returns true if the scan's values are labels, because the file or options.labels says so.
bool is_label_map(const Scan& scan, const ImportOptions& options);
/// Throws Error if the grey values look like labels, that is, if they are only a few different whole numbers.
void refuse_labels(const std::filesystem::path& file, const Scan& scan);

/// `scan`: the whole scan, or the region to import. Throws Error for a value without a tissue.
Imported import_labels(const std::filesystem::path& file, const Scan& scan, const ImportOptions& options);

}  // namespace typodont::haptics::importing

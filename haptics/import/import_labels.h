// A label map as tissue: each voxel says what it is.
#pragma once

#include "haptics/import/import.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

/// Its values are labels: the file says so, or options.labels.
bool is_label_map(const Scan& scan, const ImportOptions& options);
/// Throws Error if the greys look like labels: few whole values.
void refuse_labels(const std::filesystem::path& file, const Scan& scan);

/// `scan`: whole, or its region. Throws Error for a value without a tissue.
Imported import_labels(const std::filesystem::path& file, const Scan& scan, const ImportOptions& options);

}  // namespace typodont::haptics::importing

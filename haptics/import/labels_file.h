// Tissue labels as a volume that other programs read: NRRD (.nrrd) and NIfTI-1 (.nii), in the scan's own space.
#pragma once

#include <filesystem>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// A byte a voxel: 0 outside the body, inside it the tissue's number (Tissue), whose names an NRRD lists. Places are in
/// mm in the space of the file that was imported, whatever was turned since: LPS in an NRRD, RAS in a NIfTI file, as
/// both expect it. A file that does not say its space (a mesh, too) counts as LPS. Set-up time; throws Error.
void write_labels(const Imported& imported, const std::filesystem::path& file);

}  // namespace typodont::haptics

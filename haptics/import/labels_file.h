// Tissue labels as a volume for other programs: NRRD (.nrrd) and NIfTI-1 (.nii), in the scan's own space.
#pragma once

#include <filesystem>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// Writes one byte per voxel: 0 outside the body, the tissue's number (Tissue) inside; an NRRD file also lists the
/// names. Positions are in mm in the space of the imported file, even after rotations: LPS in an NRRD file, RAS in a
/// NIfTI file, as each format requires. An imported file that states no space, or a mesh, counts as LPS. Set-up time;
/// throws Error.
void write_labels(const Imported& imported, const std::filesystem::path& file);

}  // namespace typodont::haptics

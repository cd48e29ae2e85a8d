// Writes tissue labels as a volume for other programs, in the formats NRRD (.nrrd), NIfTI-1 (.nii) and DICOM
// segmentation (.dcm) and in the scan's own space.
#pragma once

#include <filesystem>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// Writes one byte per voxel: 0 outside the body, and the tissue's number (Tissue) inside. An NRRD file also contains a
/// list of the names. A DICOM file has one binary segment per tissue instead, and no data of a person. Positions are in
/// mm in the space of the imported file, even if the tissue was rotated: LPS in an NRRD or DICOM file, RAS in a NIfTI
/// file, as each format requires. If the imported file states no space or is a mesh, its space counts as LPS. Set-up
/// time; throws Error.
void write_labels(const Imported& imported, const std::filesystem::path& file);

}  // namespace typodont::haptics

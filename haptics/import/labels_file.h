// Writes tissue labels as a volume for other programs, in the formats NRRD (.nrrd), NIfTI-1 (.nii) and DICOM
// segmentation (.dcm) and in the scan's own space.
#pragma once

#include <filesystem>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// Writes the labels of a tissue to a file. NRRD and NIfTI files have one byte per voxel: 0 outside the body, and the
/// tissue's number (Tissue) inside. An NRRD file also has a list of the tissues' names. A DICOM file has one binary
/// segment per tissue, and no data of a person. Positions are in mm in the space of the imported file, even if the
/// tissue was rotated: LPS in an NRRD or DICOM file, RAS in a NIfTI file, as each format requires. If the imported file
/// is a mesh or states no space, its space counts as LPS. Called only at set-up; throws Error.
void write_labels(const Imported& imported, const std::filesystem::path& file);

}  // namespace typodont::haptics

// Writes tissue as volumes for other programs: the labels as NRRD (.nrrd), NIfTI-1 (.nii) or DICOM segmentation (.dcm),
// and the distances as NRRD or NIfTI-1. Positions are in the coordinates of the file from which the tissue was
// imported.
#pragma once

#include <filesystem>
#include <string_view>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// A NIfTI file's intent name: its labels are the tissues' numbers.
inline constexpr std::string_view kTissueLabels = "typodont tissue";

/// Writes the labels of a tissue to a file. NRRD and NIfTI files have one byte per voxel: 0 outside the body, and the
/// tissue's number (Tissue) inside. An NRRD file also has a list of the tissues' names. A DICOM file has one binary
/// segment per tissue, and no data of a person. Positions are in mm in the space of the imported file, even if the
/// tissue was turned or moved after the import (DenseTissue::place): LPS in an NRRD or DICOM file, RAS in a NIfTI file,
/// as each format requires. If the imported file is a mesh or states no space, its space counts as LPS. Called only at
/// set-up; throws Error.
void write_labels(const DenseTissue& tissue, const std::filesystem::path& file);

/// Writes the signed distances to the surface in mm (negative inside, limited to ± the band) as 32-bit floating-point
/// numbers to an NRRD or NIfTI file. Positions are as in write_labels(). Called only at set-up; throws Error.
void write_distances(const DenseTissue& tissue, const std::filesystem::path& file);

}  // namespace typodont::haptics

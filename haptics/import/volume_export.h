// Writes tissue as volumes for other programs: labels as NRRD, NIfTI-1 or DICOM segmentation, distances as NRRD or
// NIfTI-1. Positions are in the coordinates of the imported file.
#pragma once

#include <filesystem>
#include <string_view>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// Intent name of a NIfTI file, which says that its labels are the tissues' numbers.
inline constexpr std::string_view kTissueLabels = "typodont tissue";

/// Writes the labels of a tissue. NRRD and NIfTI: one byte per voxel, the number of the Tissue. DICOM: one binary
/// segment per tissue, no personal data.
/// Positions are in mm in the imported file's space, even if the tissue was moved (DenseTissue::place): RAS in NIfTI,
/// otherwise LPS. For set-up; throws Error.
void write_labels(const DenseTissue& tissue, const std::filesystem::path& file);

/// Writes the signed distances (mm, negative inside, limited to ± the band) as 32-bit floats to an NRRD or NIfTI file.
/// Positions as in write_labels(). For set-up; throws Error.
void write_distances(const DenseTissue& tissue, const std::filesystem::path& file);

}  // namespace typodont::haptics

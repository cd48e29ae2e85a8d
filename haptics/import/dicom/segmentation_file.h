// Writes tissue labels as a DICOM segmentation (PS3.3, Segmentation IOD).
#pragma once

#include <glm/glm.hpp>
#include <string>

namespace typodont::haptics::importing {

/// Returns a DICOM file with one binary segment for each tissue that occurs in `labels`. `labels` has the number of a
/// tissue for each of the `size` voxels (0 outside the body), with x as the fastest index. The voxel with the indices p
/// has the position step · p + origin, in mm in the space LPS. The file contains no data of a person: the elements for
/// such data, which the standard demands, are empty, and all identifiers are new random numbers. Throws Error if the
/// format cannot hold the labels; the message names `file`.
std::string dicom_segmentation(const std::string& file, const glm::ivec3& size, const std::string& labels,
                               const glm::dmat3& step, const glm::dvec3& origin);

}  // namespace typodont::haptics::importing

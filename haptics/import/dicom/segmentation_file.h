// Writes tissue labels as a DICOM segmentation (PS3.3, Segmentation IOD).
#pragma once

#include <glm/glm.hpp>
#include <string>

namespace typodont::haptics::importing {

/// One binary segment per tissue. `labels`: x fastest, 0 outside; voxel p at step · p + origin (mm, LPS). No personal
/// data, random identifiers. Throws Error with `file` if the format cannot hold it.
std::string dicom_segmentation(const std::string& file, const glm::ivec3& size, const std::string& labels,
                               const glm::dmat3& step, const glm::dvec3& origin);

}  // namespace typodont::haptics::importing

// Writes tissue labels as a DICOM segmentation (PS3.3, Segmentation IOD).
#pragma once

#include <glm/glm.hpp>
#include <string>

namespace typodont::haptics::importing {

/// Returns the file's content, with one binary segment per tissue and no personal data. `labels`: x runs fastest; voxel
/// p lies at step · p + origin (mm, LPS). Throws Error with `file` if the format cannot hold the volume.
std::string dicom_segmentation(const std::string& file, const glm::ivec3& size, const std::string& labels,
                               const glm::dmat3& step, const glm::dvec3& origin);

}  // namespace typodont::haptics::importing

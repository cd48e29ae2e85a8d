// Size of the blocks in which a sweep processes samples. Private to haptics/cutting.
#pragma once

#include <glm/glm.hpp>

namespace typodont::haptics {

inline constexpr int kRows = 4, kRowLength = 8;  // a block has kRows × kRows rows of kRowLength samples
// Centre of a block, relative to its first sample.
inline constexpr glm::vec3 kMiddle{(kRows - 1) / 2.0f, (kRows - 1) / 2.0f, (kRowLength - 1) / 2.0f};
// voxels, distance from a block's centre to its corner: |(1.5, 1.5, 3.5)|, rounded up
inline constexpr float kHalf = 4.1f;

}  // namespace typodont::haptics

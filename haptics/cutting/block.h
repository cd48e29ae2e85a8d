// The blocks of samples in which a sweep looks at what it may change. Private to haptics/cutting.
#pragma once

#include <glm/glm.hpp>

namespace typodont::haptics {

inline constexpr int kRows = 4, kDeep = 8;  // kRows × kRows rows of kDeep …
inline constexpr glm::vec3 kMiddle{(kRows - 1) / 2.0f, (kRows - 1) / 2.0f, (kDeep - 1) / 2.0f};  // … its centre …
inline constexpr float kHalf = 4.1f;  // … and how far a corner is from there, |(1.5, 1.5, 3.5)|, and a little more

}  // namespace typodont::haptics

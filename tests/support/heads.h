// Head shapes for property tests. A shape that is added to the program is included automatically.
#pragma once

#include <vector>

#include "haptics/tool.h"

namespace typodont::test {

inline std::vector<haptics::HeadShape> shapes_but_the_ball() {
  std::vector<haptics::HeadShape> shapes = haptics::head_shapes();
  std::erase(shapes, haptics::HeadShape::kSphere);
  return shapes;
}

}  // namespace typodont::test

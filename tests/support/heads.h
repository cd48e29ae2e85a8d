// Head shapes for property tests. A shape that is added to the program is included automatically.
#pragma once

#include <vector>

#include "haptics/tool.h"

namespace typodont::test {

/// All shapes that a scene can use.
inline std::vector<haptics::HeadShape> head_shapes() {
  std::vector<haptics::HeadShape> shapes;
  for (int i = 0; i < static_cast<int>(haptics::HeadShape::kShaft); ++i)
    shapes.push_back(static_cast<haptics::HeadShape>(i));
  return shapes;
}
inline std::vector<haptics::HeadShape> shapes_but_the_ball() {
  std::vector<haptics::HeadShape> shapes = head_shapes();
  std::erase(shapes, haptics::HeadShape::kSphere);
  return shapes;
}

}  // namespace typodont::test

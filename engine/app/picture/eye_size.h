// Sets the size of each eye's picture, in place of the size that the rig file states.
#pragma once

#include <string>

#include "engine/display/display_rig.h"

namespace typodont {

/// Parses --size: "WIDTHxHEIGHT", pixels of one eye. Throws Error.
glm::ivec2 parse_size(const std::string& text);

/// Sets the size of one eye's picture (pixels); the size of the panel follows from it and the layout.
void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye);

}  // namespace typodont

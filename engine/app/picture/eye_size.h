// Overrides the size of one eye's picture in the rig.
#pragma once

#include <string>

#include "engine/display/display_rig.h"

namespace typodont {

/// Parses "WIDTHxHEIGHT" of the option --size: pixels of one eye's picture. Throws Error.
glm::ivec2 parse_size(const std::string& text);

/// Sets the rig's size of one eye's picture. `eye`: pixels; the panel's pixels follow from the layout.
void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye);

}  // namespace typodont

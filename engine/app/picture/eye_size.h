// Replaces the picture size of one eye that the rig file states.
#pragma once

#include <string>

#include "engine/display/display_rig.h"

namespace typodont {

/// Parses the value "WIDTHxHEIGHT" of the option --size: the size of one eye's picture in pixels. Throws Error.
glm::ivec2 parse_size(const std::string& text);

/// Sets the size of one eye's picture (`eye`, pixels) in the display rig. The size of the panel is computed from it and
/// the layout.
void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye);

}  // namespace typodont

// Another size of an eye's picture than the rig file's.
#pragma once

#include <string>

#include "engine/display/display_rig.h"

namespace typodont {

/// "WIDTHxHEIGHT" of --size, pixels of one eye. Throws Error.
glm::ivec2 parse_size(const std::string& text);

/// The panel's size follows from `eye` (pixels) and the layout.
void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye);

}  // namespace typodont

// Draws text into a picture in host memory, with the program's built-in font.
#pragma once

#include <string_view>

#include "engine/render/picture.h"

namespace typodont::render {

/// Returns the width in pixels of a text of this height. ASCII only; other characters are drawn as '?'.
double text_width(std::string_view text, double height);
/// Writes text. `at`: pixel at the left end of the baseline; `color`: sRGB.
void write_text(Picture& picture, glm::dvec2 at, double height, std::string_view text, glm::u8vec3 color);

}  // namespace typodont::render

// Draws text with the built-in font into a picture in main memory.
#pragma once

#include <string_view>

#include "engine/render/picture.h"

namespace typodont::render {

/// Width of a text in pixels. Other characters than ASCII become '?'.
double text_width(std::string_view text, double height);
/// `at`: left end of the baseline, pixels; `color`: sRGB.
void write_text(Picture& picture, glm::dvec2 at, double height, std::string_view text, glm::u8vec3 color);

}  // namespace typodont::render

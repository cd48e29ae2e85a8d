// Text with the built-in font, on the host.
#pragma once

#include <string_view>

#include "engine/render/picture.h"

namespace typodont::render {

/// Pixels. ASCII; others are '?'.
double text_width(std::string_view text, double height);
/// `at`: left end of the baseline; `color`: sRGB.
void write_text(Picture& picture, glm::dvec2 at, double height, std::string_view text, glm::u8vec3 color);

}  // namespace typodont::render

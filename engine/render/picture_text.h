// Writing in a picture on the host, in the font that is baked into the program.
#pragma once

#include <string_view>

#include "engine/render/picture.h"

namespace typodont::render {

/// Pixels that a text of this height takes across. ASCII; anything else is shown as '?'.
double text_width(std::string_view text, double height);
/// `at`: where its baseline begins, in pixels; `color`: sRGB.
void write_text(Picture& picture, glm::dvec2 at, double height, std::string_view text, glm::u8vec3 color);

}  // namespace typodont::render

#include "engine/app/picture/eye_size.h"

#include <fmt/format.h>

#include <cstdio>

#include "engine/base/error.h"

namespace typodont {

glm::ivec2 parse_size(const std::string& text) {
  int w = 0, h = 0, end = 0;
  const bool read = std::sscanf(text.c_str(), "%5dx%5d%n", &w, &h, &end) == 2 && end == static_cast<int>(text.size());
  if (!read || w < 16 || h < 16 || w > 8192 || h > 8192)
    throw Error("", "--size", fmt::format("\"{}\"", text), "WIDTHxHEIGHT of one eye's picture, 16 to 8192 pixels each");
  return {w, h};
}

void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye) {
  const display::Layout layout = rig.screen.layout;
  const bool shares_panel = layout == display::Layout::kSideBySide || layout == display::Layout::kTopBottom;
  rig.screen.pixels = shares_panel ? display::screen_pixels(layout, eye) : eye;
}

}  // namespace typodont

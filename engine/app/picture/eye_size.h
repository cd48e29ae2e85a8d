// The size of one eye's picture, asked for instead of the rig's.
#pragma once

#include "engine/display/display_rig.h"

namespace typodont {

/// `eye`: pixels of one eye's picture; those of the panel follow from the layout.
inline void draw_eyes_at(display::DisplayRig& rig, const glm::ivec2& eye) {
  const display::Layout layout = rig.screen.layout;
  const bool shares_panel = layout == display::Layout::kSideBySide || layout == display::Layout::kTopBottom;
  rig.screen.pixels = shares_panel ? display::screen_pixels(layout, eye) : eye;
}

}  // namespace typodont

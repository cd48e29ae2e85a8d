// The region of the target for each eye, and how pixels of both eyes are combined; used by GPU and CPU composition.
#pragma once

#include <cstdint>

#include "engine/display/display_rig.h"

namespace typodont::display {

/// How a pixel combines the pictures of both eyes; the values are those of kMix in compose.frag.
enum class Mix : std::uint32_t { kOneEye, kRows, kAnaglyph };
inline constexpr std::size_t kMixes = 3;
constexpr Mix mix_of(Layout layout) {
  return layout == Layout::kRowInterleaved ? Mix::kRows : layout == Layout::kAnaglyph ? Mix::kAnaglyph : Mix::kOneEye;
}

/// Region of the target that shows an eye's picture.
struct Place {
  ivec2 lo{0}, size{0};
};
inline Place place_of(int eye, Layout how, const ivec2& target) {
  Place place{{0, 0}, target};
  if (how == Layout::kSideBySide || how == Layout::kTwoOutputs) {
    place.size.x = target.x / 2;
    place.lo.x = eye * place.size.x;
  } else if (how == Layout::kTopBottom || how == Layout::kFrameSequential) {
    place.size.y = target.y / 2;
    place.lo.y = eye * place.size.y;
  }
  return place;
}
/// Returns true if each eye has its own region.
constexpr bool two_places(Layout layout) {
  return mix_of(layout) == Mix::kOneEye && layout != Layout::kMono;
}

}  // namespace typodont::display

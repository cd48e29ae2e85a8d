// Each eye's region of the target, and how pixels combine. For both composers.
#pragma once

#include <cstdint>

#include "engine/display/display_rig.h"

namespace typodont::display {

/// As kMix in compose.frag.
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
/// A region of its own per eye.
constexpr bool two_places(Layout layout) {
  return mix_of(layout) == Mix::kOneEye && layout != Layout::kMono;
}

}  // namespace typodont::display

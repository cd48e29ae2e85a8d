// What of a user interface's frame differs from an earlier one, by tiles: each has a word that stands for all that is
// drawn over it, in its order. A clock that goes on costs its own tiles, not the window's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/display/output.h"

struct ImDrawData;

namespace typodont {

/// A word a tile, row by row. `textures`: a word for what each texture shows, by the number the lists name it by.
std::vector<std::uint64_t> drawn_tiles(const ImDrawData& lists, display::ivec2 size,
                                       std::span<const std::uint64_t> textures);

/// Where two frames of that size differ: few rectangles that do not overlap.
std::vector<display::Part> differing_parts(std::span<const std::uint64_t> before, std::span<const std::uint64_t> after,
                                           display::ivec2 size);

/// Two words in one that tells them, and their order, apart.
inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  a = (a ^ b) * 0x9e3779b97f4a7c15u;
  return a ^ a >> 29;
}

}  // namespace typodont

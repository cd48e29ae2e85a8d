// Finds the tiles that differ between two frames of the interface, by a hash of all drawn elements in each tile. For
// example, a running clock redraws only its own tiles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/display/output.h"

struct ImDrawData;

namespace typodont {

/// Returns the hashes of all tiles, row by row. `textures`: for each texture, a number that changes with its content.
std::vector<std::uint64_t> drawn_tiles(const ImDrawData& lists, display::ivec2 size,
                                       std::span<const std::uint64_t> textures);

/// The changed area as a few rectangles that do not overlap. `size`: width and height of the window, pixels.
std::vector<display::Part> differing_parts(std::span<const std::uint64_t> before, std::span<const std::uint64_t> after,
                                           display::ivec2 size);

/// Combines two hashes; the result depends on their order.
inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  a = (a ^ b) * 0x9e3779b97f4a7c15u;
  return a ^ a >> 29;
}

}  // namespace typodont

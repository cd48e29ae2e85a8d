// Finds the parts of a user-interface frame that differ from an earlier frame. The frame is divided into tiles. Each
// tile has a hash of all elements that are drawn over it, in order. So a running clock redraws only its own tiles, not
// the whole window.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/display/output.h"

struct ImDrawData;

namespace typodont {

/// Returns one hash per tile, row by row. `textures`: one number for each texture in the draw lists; the number changes
/// whenever the texture's content changes.
std::vector<std::uint64_t> drawn_tiles(const ImDrawData& lists, display::ivec2 size,
                                       std::span<const std::uint64_t> textures);

/// Returns the parts in which two frames of this size (pixels) differ: a few rectangles that do not overlap.
std::vector<display::Part> differing_parts(std::span<const std::uint64_t> before, std::span<const std::uint64_t> after,
                                           display::ivec2 size);

/// Combines two hashes. The result depends on both hashes and on their order.
inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  a = (a ^ b) * 0x9e3779b97f4a7c15u;
  return a ^ a >> 29;
}

}  // namespace typodont

// What differs between two frames of the interface, by a hash per tile of all elements over it. A running clock redraws
// only its tiles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/display/output.h"

struct ImDrawData;

namespace typodont {

/// Row by row. `textures`: a number each, which changes with the content.
std::vector<std::uint64_t> drawn_tiles(const ImDrawData& lists, display::ivec2 size,
                                       std::span<const std::uint64_t> textures);

/// A few rectangles that do not overlap. Size in pixels.
std::vector<display::Part> differing_parts(std::span<const std::uint64_t> before, std::span<const std::uint64_t> after,
                                           display::ivec2 size);

/// Depends on the order.
inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  a = (a ^ b) * 0x9e3779b97f4a7c15u;
  return a ^ a >> 29;
}

}  // namespace typodont

#include "engine/app/operator/drawn_tiles.h"

#include <imgui.h>

#include <algorithm>
#include <bit>

namespace typodont {

namespace {

constexpr int kTile = 32;  // pixels, side of a tile
// Largest number of changed rectangles. An interface element is drawn once for each rectangle that it overlaps, so more
// rectangles would take longer.
constexpr std::size_t kMaxParts = 12;

int tiles_in(int pixels) {
  return (pixels + kTile - 1) / kTile;
}

std::uint64_t word(float a, float b) {
  return std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32 | std::bit_cast<std::uint32_t>(b);
}
std::uint64_t word(const ImDrawVert& v) {
  return mixed(mixed(word(v.pos.x, v.pos.y), word(v.uv.x, v.uv.y)), v.col);
}

}  // namespace

std::vector<std::uint64_t> drawn_tiles(const ImDrawData& lists, display::ivec2 size,
                                       std::span<const std::uint64_t> textures) {
  const int across = tiles_in(size.x), down = tiles_in(size.y);
  std::vector<std::uint64_t> tiles(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 0);
  for (int i = 0; i < lists.CmdListsCount; ++i) {
    const ImDrawList& list = *lists.CmdLists[i];
    for (const ImDrawCmd& c : list.CmdBuffer) {
      const ImVec4 clip = c.ClipRect;
      const auto number = std::min(reinterpret_cast<std::uintptr_t>(c.GetTexID()), textures.size() - 1);
      const std::uint64_t how = mixed(mixed(word(clip.x, clip.y), word(clip.z, clip.w)), textures[number]);
      const ImDrawIdx* const index = list.IdxBuffer.Data + c.IdxOffset;
      const ImDrawVert* const vertex = list.VtxBuffer.Data + c.VtxOffset;
      for (unsigned k = 0; k + 2 < c.ElemCount; k += 3) {
        const ImDrawVert &p = vertex[index[k]], &q = vertex[index[k + 1]], &r = vertex[index[k + 2]];
        const float x0 = std::max(std::min({p.pos.x, q.pos.x, r.pos.x}), std::max(clip.x, 0.0f)),
                    y0 = std::max(std::min({p.pos.y, q.pos.y, r.pos.y}), std::max(clip.y, 0.0f)),
                    x1 = std::min(std::max({p.pos.x, q.pos.x, r.pos.x}), std::min(clip.z, static_cast<float>(size.x))),
                    y1 = std::min(std::max({p.pos.y, q.pos.y, r.pos.y}), std::min(clip.w, static_cast<float>(size.y)));
        if (!(x0 < x1 && y0 < y1)) continue;
        const std::uint64_t says = mixed(mixed(mixed(how, word(p)), word(q)), word(r));
        const int left = static_cast<int>(x0) / kTile, right = std::min(static_cast<int>(x1) / kTile, across - 1);
        const int last = std::min(static_cast<int>(y1) / kTile, down - 1);
        for (int y = static_cast<int>(y0) / kTile; y <= last; ++y)
          for (int x = left; x <= right; ++x) {
            std::uint64_t& tile = tiles[static_cast<std::size_t>(y * across + x)];
            tile = mixed(tile, says);
          }
      }
    }
  }
  return tiles;
}

std::vector<display::Part> differing_parts(std::span<const std::uint64_t> before, std::span<const std::uint64_t> after,
                                           display::ivec2 size) {
  if (before.size() != after.size()) return {{0, 0, size.x, size.y}};
  // Neighbouring tiles of a row form a rectangle. It grows downwards if the next row has the same changed tiles.
  std::vector<display::Part> parts;
  const int across = tiles_in(size.x), down = tiles_in(size.y);
  for (int y = 0; y < down; ++y) {
    const auto differs = [&](int x) {
      const auto i = static_cast<std::size_t>(y * across + x);
      return before[i] != after[i];
    };
    for (int x = 0; x < across; ++x) {
      if (!differs(x)) continue;
      const int from = x;
      while (x < across && differs(x)) ++x;
      const auto above = std::find_if(parts.begin(), parts.end(), [&](const display::Part& p) {
        return p.x == from && p.width == x - from && p.y + p.height == y;
      });
      if (above != parts.end())
        ++above->height;
      else
        parts.push_back({from, y, x - from, 1});
    }
  }
  if (parts.size() > kMaxParts) {
    display::ivec2 lo(across, down), hi(0);
    for (const display::Part& p : parts) {
      lo = glm::min(lo, display::ivec2(p.x, p.y));
      hi = glm::max(hi, display::ivec2(p.x + p.width, p.y + p.height));
    }
    parts = {{lo.x, lo.y, hi.x - lo.x, hi.y - lo.y}};
  }
  for (display::Part& p : parts) {
    p = {p.x * kTile, p.y * kTile, p.width * kTile, p.height * kTile};
    p.width = std::min(p.width, size.x - p.x);
    p.height = std::min(p.height, size.y - p.y);
  }
  return parts;
}

}  // namespace typodont

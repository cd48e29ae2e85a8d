#include "engine/display/compose/by_processor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/base/dispatch.h"

namespace typodont::display {

namespace {

#define TYPODONT_VERSIONS TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")

// Mask for bytes 0 and 2, which leaves room to multiply both by 0…256 at once.
constexpr std::uint32_t kEven = 0x00ff00ff;

/// Converts RGBA to BGRA.
constexpr std::uint32_t swapped(std::uint32_t p) {
  return (p & 0xff00ff00) | (p & 0xff) << 16 | (p >> 16 & 0xff);
}

TYPODONT_VERSIONS
void stretch(const std::uint32_t* __restrict source, const std::int32_t* __restrict from,
             const std::uint32_t* __restrict on, std::uint32_t* __restrict out, int count) {
  for (int i = 0; i < count; ++i) {
    const std::uint32_t a = source[from[i]], b = source[from[i] + 1], w = on[i], v = 256 - w;
    const std::uint32_t even = ((a & kEven) * v + (b & kEven) * w + 0x00800080) >> 8 & kEven;
    const std::uint32_t odd = ((a >> 8 & kEven) * v + (b >> 8 & kEven) * w + 0x00800080) & ~kEven;
    out[i] = swapped(even | odd);
  }
}

TYPODONT_VERSIONS
void swap_bytes(const std::uint32_t* __restrict source, std::uint32_t* __restrict out, int count) {
  for (int i = 0; i < count; ++i) out[i] = swapped(source[i]);
}

/// Interpolates between two rows. Each byte is interpolated separately.
TYPODONT_VERSIONS
void between(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, std::uint16_t w,
             std::uint8_t* __restrict out, int bytes) {
  const std::uint16_t v = static_cast<std::uint16_t>(256 - w);
  for (int i = 0; i < bytes; ++i)
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(a[i] * v + b[i] * w + 128) >> 8);
}

/// For red-cyan glasses: red of one row, green and blue of the other.
TYPODONT_VERSIONS
void mix_colors(const std::uint32_t* __restrict red, const std::uint32_t* __restrict cyan,
                std::uint32_t* __restrict out, int count) {
  for (int i = 0; i < count; ++i) out[i] = (red[i] & 0x00ff0000) | (cyan[i] & 0xff00ffff);
}

/// Writes a row of the target, whose place in the region is 0..1 from its upper edge. `places`: one eye's part of a
/// Warp.
void warp_row(const std::vector<glm::vec2>& places, const std::uint32_t* source, const ivec2& size, float down,
              float first, float step, std::uint32_t* out, int count) {
  constexpr int kCells = kWarpSide - 1;
  const float row = down * kCells;
  const int upper = std::min(static_cast<int>(row), kCells - 1);
  const float lower_share = row - static_cast<float>(upper);
  std::array<glm::vec2, kWarpSide> at;  // pixels of the source
  for (std::size_t i = 0; i < at.size(); ++i) {
    const std::size_t k = static_cast<std::size_t>(upper * kWarpSide) + i;
    at[i] = glm::mix(places[k], places[k + kWarpSide], lower_share) * glm::vec2(size) - 0.5f;
  }
  const glm::vec2 last = glm::vec2(size - 1);
  for (int x = 0; x < count; ++x) {
    const float column = (first + static_cast<float>(x) * step) * kCells;
    const int cell = std::min(static_cast<int>(column), kCells - 1);
    const auto c = static_cast<std::size_t>(cell);
    const glm::vec2 p = glm::clamp(glm::mix(at[c], at[c + 1], column - static_cast<float>(cell)), glm::vec2(0), last);
    const ivec2 lo = glm::min(ivec2(p), size - 2);
    const auto wx = static_cast<std::uint32_t>(256 * (p.x - static_cast<float>(lo.x)) + 0.5f),
               wy = static_cast<std::uint32_t>(256 * (p.y - static_cast<float>(lo.y)) + 0.5f);
    const std::uint32_t* const s = source + static_cast<std::size_t>(lo.y) * static_cast<std::size_t>(size.x) + lo.x;
    std::uint32_t pixel = 0;
    for (int byte = 0; byte < 32; byte += 8) {
      const auto of = [&](std::uint32_t rgba) { return rgba >> byte & 0xff; };
      const std::uint32_t top = of(s[0]) * (256 - wx) + of(s[1]) * wx,
                          bottom = of(s[size.x]) * (256 - wx) + of(s[size.x + 1]) * wx;
      pixel |= (top * (256 - wy) + bottom * wy + 0x8000) >> 16 << byte;
    }
    out[x] = swapped(pixel);
  }
}

std::uint8_t* bytes(std::uint32_t* p) {
  return reinterpret_cast<std::uint8_t*>(p);
}
const std::uint8_t* bytes(const std::uint32_t* p) {
  return reinterpret_cast<const std::uint8_t*>(p);
}

}  // namespace

void ProcessorComposer::SourcePixels::fit(int source_size, int target_size) {
  if (source == source_size && target == target_size) return;
  source = source_size;
  target = target_size;
  from.resize(static_cast<std::size_t>(target));
  on.resize(static_cast<std::size_t>(target));
  for (int i = 0; i < target; ++i) {
    // Centre of the target pixel in source pixels, limited so that the next source pixel always exists.
    const double at = std::clamp((i + 0.5) * source / target - 0.5, 0.0, source - 1.0);
    const int lower = std::min(static_cast<int>(at), std::max(source - 2, 0));
    from[static_cast<std::size_t>(i)] = lower;
    on[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(std::lround(256 * (at - lower)));
  }
}

const std::uint32_t* ProcessorComposer::stretched(const EyePixels& eyes, int eye, int row, int first, int count) {
  const auto e = static_cast<std::size_t>(eye);
  auto& kept = rows_[e];
  for (const Row& r : kept)
    if (r.of == row) return r.pixels.data();
  // Rows are requested from top to bottom, so of the two stored rows, the upper one is replaced.
  Row& fresh = kept[0].of < kept[1].of ? kept[0] : kept[1];
  fresh.of = row;
  fresh.pixels.resize(static_cast<std::size_t>(count));
  const auto* source = reinterpret_cast<const std::uint32_t*>(eyes.first[e]) +
                       static_cast<std::size_t>(row) * static_cast<std::size_t>(eyes.size.x);
  if (across_.source == across_.target)
    swap_bytes(source + first, fresh.pixels.data(), count);
  else
    stretch(source, across_.from.data() + first, across_.on.data() + first, fresh.pixels.data(), count);
  return fresh.pixels.data();
}

void ProcessorComposer::compose(const EyePixels& eyes, Mix mix, const Place& place, int eye, const Part& part,
                                std::uint8_t* out, std::size_t pitch, const Warp* warp) {
  if (part.width <= 0 || part.height <= 0) return;
  across_.fit(eyes.size.x, place.size.x);
  down_.fit(eyes.size.y, place.size.y);
  for (auto& of_eye : rows_)
    for (Row& row : of_eye) row.of = -1;
  const int first = part.x - place.lo.x;
  const auto row_of = [&](int of_eye, int y, std::uint32_t* to) {
    if (warp) {
      const auto e = static_cast<std::size_t>(of_eye);
      const float step = 1 / static_cast<float>(place.size.x);
      return warp_row((*warp)[e], reinterpret_cast<const std::uint32_t*>(eyes.first[e]), eyes.size,
                      (static_cast<float>(y) + 0.5f) / static_cast<float>(place.size.y),
                      (static_cast<float>(first) + 0.5f) * step, step, to, part.width);
    }
    const auto i = static_cast<std::size_t>(y);
    const std::uint32_t on = down_.on[i];
    const int upper = down_.from[i] + (on == 256 ? 1 : 0);
    const std::uint32_t* a = stretched(eyes, of_eye, upper, first, part.width);
    if (on == 0 || on == 256) {
      std::memcpy(to, a, 4 * static_cast<std::size_t>(part.width));
    } else {
      const std::uint32_t* b = stretched(eyes, of_eye, upper + 1, first, part.width);
      between(bytes(a), bytes(b), static_cast<std::uint16_t>(on), bytes(to), 4 * part.width);
    }
  };
  for (int y = part.y; y < part.y + part.height; ++y) {
    auto* to = reinterpret_cast<std::uint32_t*>(out + static_cast<std::size_t>(y) * pitch) + part.x;
    const int row = y - place.lo.y;
    if (mix == Mix::kAnaglyph) {
      other_.resize(2 * static_cast<std::size_t>(part.width));
      row_of(0, row, other_.data());
      row_of(1, row, other_.data() + part.width);
      mix_colors(other_.data(), other_.data() + part.width, to, part.width);
    } else {
      row_of(mix == Mix::kRows ? (row + eye) & 1 : eye, row, to);
    }
  }
}

}  // namespace typodont::display

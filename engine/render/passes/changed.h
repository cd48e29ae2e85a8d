// Finds the tiles of the picture to redraw: those that tool, shadow, changed tissue, cursor or particles touch in this
// frame or touched in the last. Does not use Vulkan.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "engine/render/mirror.h"
#include "engine/render/shared.h"
#include "engine/render/sight.h"

namespace typodont::render {

using EyeBoxes = std::array<std::vector<PixelBox>, 2>;  // parts of each eye's picture

/// Pixels that a box covers, and one more on each side; the whole picture if part of the box is behind the eye.
PixelBox seen_in(const glm::dmat4& clip_from_box, const glm::vec3& lo, const glm::vec3& hi, const glm::ivec2& size);

/// Tiles of one eye's picture. Marked tiles are redrawn.
class Tiles {
 public:
  static constexpr int kSide = 16;  // pixels, side of a tile
  void clear(glm::ivec2 picture);
  void mark(const PixelBox& box);
  void mark(const Tiles& other);
  void mark_all();
  bool touch(const PixelBox& box) const;
  bool touch(const Tiles& other) const;
  double fraction() const;  // fraction of the picture's tiles that are marked
  bool operator==(const Tiles&) const = default;
  /// Marked (or unmarked) tiles inside `within`, combined into few boxes.
  std::vector<PixelBox> boxes(bool marked, const PixelBox& within) const;
  PixelBox picture() const { return {0, 0, size_.x, size_.y}; }
  /// Bounding box of all marked tiles.
  PixelBox bounds() const;

 private:
  glm::ivec2 size_{0}, count_{0};
  std::vector<std::uint8_t> marked_;
};

/// Returns true if the cursor's ring may appear on a surface in this ball.
bool cursor_marks(const shared::FrameData& data, const glm::vec3& center, float radius);

/// Returns true if the tool's shadow or occlusion may change a surface in this ball, as in shaders/lighting.glsl.
bool tool_shades(const shared::FrameData& data, const glm::vec3& center, float radius);

/// Part of the shadow map in which tissue has changed. All points whose shaders read this part may look different.
struct ShadowMapBox {
  glm::vec2 lo{1e9f}, hi{-1e9f};  // corners of the rectangle in shadow-map coordinates, 0..1
  bool empty() const { return lo.x > hi.x; }
  void take(const ShadowMapBox& b) {
    lo = glm::min(lo, b.lo);
    hi = glm::max(hi, b.hi);
  }
  bool meets(const ShadowMapBox& b) const {
    return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y;
  }
};
ShadowMapBox shadow_map_box(const glm::dmat4& light_from_box, const glm::vec3& lo, const glm::vec3& hi);
/// Largest distance in the map, 0..1, between a point and the texels that its shader reads.
float shadow_lookup_reach(const shared::FrameData& data);

}  // namespace typodont::render

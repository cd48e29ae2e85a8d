// What of the pictures a frame changes, so that the rest stays as it was drawn before: tiles that the tool, its shadow,
// changed tissue, the cursor or particles touch, now or in the frame before. No Vulkan.
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

/// Pixels that a box of a mesh can cover, a pixel more all round; the whole picture where it reaches behind the eye.
PixelBox seen_in(const glm::dmat4& clip_from_box, const glm::vec3& lo, const glm::vec3& hi, const glm::ivec2& size);

/// Tiles of one eye's picture.
class Tiles {
 public:
  static constexpr int kSide = 16;  // pixels
  void clear(glm::ivec2 picture);
  void mark(const PixelBox& box);
  void mark(const Tiles& other);
  void mark_all();
  bool touch(const PixelBox& box) const;
  bool touch(const Tiles& other) const;
  double share() const;  // of the picture
  bool operator==(const Tiles&) const = default;
  /// The tiles that are marked (or are not) within `within`, as few boxes.
  std::vector<PixelBox> boxes(bool marked, const PixelBox& within) const;
  PixelBox picture() const { return {0, 0, size_.x, size_.y}; }
  /// The box round all that is marked.
  PixelBox bounds() const;

 private:
  glm::ivec2 size_{0}, count_{0};
  std::vector<std::uint8_t> marked_;
};

/// Whether the cursor's ring may be drawn on what lies within a ball.
bool cursor_marks(const shared::FrameData& data, const glm::vec3& center, float radius);

/// Whether the tool takes light from anything in a ball: its shadow and its occlusion, as in shaders/lighting.glsl.
bool tool_shades(const shared::FrameData& data, const glm::vec3& center, float radius);

/// What changed tissue changes beside itself: all whose shadow or occlusion is looked up near it in the lamp's map.
struct LampBox {
  glm::vec2 lo{1e9f}, hi{-1e9f};  // of the map, 0..1
  bool empty() const { return lo.x > hi.x; }
  void take(const LampBox& b) {
    lo = glm::min(lo, b.lo);
    hi = glm::max(hi, b.hi);
  }
  bool meets(const LampBox& b) const { return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y; }
};
LampBox in_lamp(const glm::dmat4& light_from_box, const glm::vec3& lo, const glm::vec3& hi);
/// How far around itself, of the map.
float lamp_reach(const shared::FrameData& data);

}  // namespace typodont::render

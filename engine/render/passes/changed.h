// Finds the tiles of the picture to redraw: those that tool, shadow, changed tissue, cursor or particles touch in this
// frame or touched in the last. Does not use Vulkan.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
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
  /// Fraction of the picture's tiles that are marked.
  double fraction() const { return marked_.empty() ? 0 : marked_count_ / static_cast<double>(marked_.size()); }
  bool operator==(const Tiles&) const = default;
  /// Marked (or unmarked) tiles inside `within`, combined into few boxes.
  std::vector<PixelBox> boxes(bool marked, const PixelBox& within) const;
  PixelBox picture() const { return {0, 0, size_.x, size_.y}; }
  /// Bounding box of all marked tiles.
  PixelBox bounds() const;

 private:
  void mark_tile(std::size_t tile) { marked_count_ += 1 - std::exchange(marked_[tile], std::uint8_t{1}); }

  glm::ivec2 size_{0}, count_{0};
  std::vector<std::uint8_t> marked_;
  int marked_count_ = 0;
};

/// Marked fraction of the first `views` pictures.
double marked_fraction(const std::array<Tiles, 2>& tiles, int views);
/// If this fraction is marked, the whole picture is redrawn.
inline constexpr double kFullRedrawFraction = 0.8;

/// Returns true if the cursor's ring may appear on a surface in this ball.
bool cursor_marks(const shared::FrameData& data, const glm::vec3& center, float radius);

/// The part of space in which the tool's shadow or occlusion may change a surface, as in shaders/lighting.glsl.
class ToolShade {
 public:
  explicit ToolShade(const shared::FrameData& data);
  /// Returns true if the ball around `center` may contain such a surface. m, frame W.
  bool reaches(const glm::vec3& center, float radius) const;

 private:
  static constexpr std::size_t kPieces = 6;
  /// A round cone that casts a shadow. The arrays describe points that divide its axis into pieces.
  struct Caster {
    std::array<glm::vec3, kPieces + 1> axis;  // m, frame W
    std::array<glm::vec3, kPieces + 1> seen;  // the points, projected onto the plane perpendicular to the light
    std::array<float, kPieces + 1> height;    // m, along the direction to the light
    std::array<float, kPieces + 1> thick;     // m, radius of the cone
    float reach, occlusion;                   // m, longest reach of shadow and of occlusion
  };
  bool reaches(const Caster& caster, std::size_t from, std::size_t to, const glm::vec3& center, const glm::vec3& seen,
               float height, float radius) const;

  glm::vec3 to_light_;
  float spread_;  // tangent of the angle by which the border of a shadow widens
  std::array<Caster, 3> casters_{};
  int count_ = 0;
};

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

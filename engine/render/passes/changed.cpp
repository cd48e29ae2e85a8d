#include "engine/render/passes/changed.h"

#include <algorithm>
#include <cmath>

#include "engine/base/nearest.h"

namespace typodont::render {

PixelBox seen_in(const glm::dmat4& clip_from_box, const glm::vec3& lo, const glm::vec3& hi, const glm::ivec2& size) {
  glm::dvec2 least(1e9), most(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 c =
        clip_from_box * glm::dvec4(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z, 1);
    if (c.w < 1e-6) return {0, 0, size.x, size.y};
    const glm::dvec2 p = (0.5 + 0.5 * glm::dvec2(c) / c.w) * glm::dvec2(size);
    least = glm::min(least, p);
    most = glm::max(most, p);
  }
  const glm::dvec2 edge(size);
  const glm::ivec2 a(glm::floor(glm::clamp(least - 1.0, glm::dvec2(0), edge))),
      b(glm::ceil(glm::clamp(most + 1.0, glm::dvec2(0), edge)));
  return {a.x, a.y, b.x - a.x, b.y - a.y};
}

void Tiles::clear(glm::ivec2 picture) {
  size_ = picture;
  count_ = (picture + kSide - 1) / kSide;
  marked_.assign(static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y), 0);
  marked_count_ = 0;
}

void Tiles::mark(const PixelBox& box) {
  if (box.width <= 0 || box.height <= 0) return;
  const int x0 = std::max(box.x / kSide, 0), x1 = std::min((box.x + box.width - 1) / kSide, count_.x - 1);
  const int y0 = std::max(box.y / kSide, 0), y1 = std::min((box.y + box.height - 1) / kSide, count_.y - 1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) mark_tile(static_cast<std::size_t>(y * count_.x + x));
}

void Tiles::mark(const Tiles& other) {
  if (other.marked_.size() != marked_.size()) return;
  for (std::size_t i = 0; i < marked_.size(); ++i)
    if (other.marked_[i]) mark_tile(i);
}

void Tiles::mark_all() {
  std::fill(marked_.begin(), marked_.end(), std::uint8_t{1});
  marked_count_ = static_cast<int>(marked_.size());
}

bool Tiles::touch(const PixelBox& box) const {
  if (box.width <= 0 || box.height <= 0) return false;
  const int x0 = std::max(box.x / kSide, 0), x1 = std::min((box.x + box.width - 1) / kSide, count_.x - 1);
  const int y0 = std::max(box.y / kSide, 0), y1 = std::min((box.y + box.height - 1) / kSide, count_.y - 1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      if (marked_[static_cast<std::size_t>(y * count_.x + x)]) return true;
  return false;
}

bool Tiles::touch(const Tiles& other) const {
  if (other.marked_.size() != marked_.size()) return false;
  for (std::size_t i = 0; i < marked_.size(); ++i)
    if (marked_[i] && other.marked_[i]) return true;
  return false;
}

std::vector<PixelBox> Tiles::boxes(bool marked, const PixelBox& within) const {
  std::vector<PixelBox> out;
  const int x0 = within.x / kSide, x1 = (within.x + within.width + kSide - 1) / kSide;
  const int y0 = within.y / kSide, y1 = (within.y + within.height + kSide - 1) / kSide;
  for (int y = y0; y < std::min(y1, count_.y); ++y)
    for (int x = x0; x < std::min(x1, count_.x); ++x) {
      if ((marked_[static_cast<std::size_t>(y * count_.x + x)] != 0) != marked) continue;
      int end = x + 1;
      while (end < std::min(x1, count_.x) && (marked_[static_cast<std::size_t>(y * count_.x + end)] != 0) == marked)
        ++end;
      const PixelBox run{x * kSide, y * kSide, std::min(end * kSide, size_.x) - x * kSide,
                         std::min((y + 1) * kSide, size_.y) - y * kSide};
      x = end;
      // Joins the run of tiles with a box directly above that has the same left and right edge.
      const auto above = std::find_if(out.begin(), out.end(), [&](const PixelBox& b) {
        return b.x == run.x && b.width == run.width && b.y + b.height == run.y;
      });
      if (above != out.end())
        above->height += run.height;
      else
        out.push_back(run);
    }
  return out;
}

PixelBox Tiles::bounds() const {
  glm::ivec2 lo = count_, hi(-1);
  for (int y = 0; y < count_.y; ++y)
    for (int x = 0; x < count_.x; ++x)
      if (marked_[static_cast<std::size_t>(y * count_.x + x)]) {
        lo = glm::min(lo, glm::ivec2(x, y));
        hi = glm::max(hi, glm::ivec2(x, y));
      }
  if (hi.x < 0) return {};
  const glm::ivec2 a = lo * kSide, b = glm::min((hi + 1) * kSide, size_);
  return {a.x, a.y, b.x - a.x, b.y - a.y};
}

double marked_fraction(const std::array<Tiles, 2>& tiles, int views) {
  double sum = 0;
  for (int e = 0; e < views; ++e) sum += tiles[static_cast<std::size_t>(e)].fraction();
  return sum / views;
}

namespace {

// Distance by which light inside tissue widens a tool's shadow, m, as in lighting.glsl.
constexpr float kShadowScatter = 1.4e-3f;

}  // namespace

ToolShade::ToolShade(const shared::FrameData& data) : to_light_(data.key), spread_(data.lamp.x) {
  // m, as in lighting.glsl: reach of the tool's occlusion, of its shadow, and of the handpiece's shadow.
  constexpr float kToolReach = 3.0e-3f, kToolShadowReach = 25e-3f, kHandpieceReach = 40e-3f;
  if (data.tool_head.w <= 0) return;
  const auto add = [&](const glm::vec4& a, const glm::vec4& b, float reach, float occlusion) {
    if (a.w <= 0 && b.w <= 0) return;
    Caster& caster = casters_[static_cast<std::size_t>(count_++)];
    for (std::size_t i = 0; i <= kPieces; ++i) {
      const glm::vec4 point = glm::mix(a, b, static_cast<float>(i) / kPieces);
      caster.axis[i] = glm::vec3(point);
      caster.height[i] = glm::dot(caster.axis[i], to_light_);
      caster.seen[i] = caster.axis[i] - caster.height[i] * to_light_;
      caster.thick[i] = point.w;
    }
    caster.reach = reach, caster.occlusion = occlusion;
  };
  const float thick = std::max(data.tool_head.w, data.tool_end.w);
  add({glm::vec3(data.tool_head), thick}, {glm::vec3(data.tool_end), thick}, kToolShadowReach, kToolReach);
  for (const int cone : {0, 2}) add(data.handpiece[cone], data.handpiece[cone + 1], kHandpieceReach, 0);
}

bool ToolShade::reaches(const Caster& caster, std::size_t from, std::size_t to, const glm::vec3& center,
                        const glm::vec3& seen, float height, float radius) const {
  if (caster.occlusion > 0 &&
      distance_to_segment(caster.axis[from], caster.axis[to], center) - radius < caster.occlusion)
    return true;
  const float f = caster.height[from] - height, t = caster.height[to] - height, way = std::max(f, t) + radius;
  if (way <= 0 || std::min(f, t) - radius > caster.reach) return false;
  const float soft = 0.08e-3f + spread_ * way + kShadowScatter, thick = std::max(caster.thick[from], caster.thick[to]);
  return distance_to_segment(caster.seen[from], caster.seen[to], seen) - radius < thick + soft;
}

bool ToolShade::reaches(const glm::vec3& center, float radius) const {
  const float height = glm::dot(center, to_light_);
  const glm::vec3 seen = center - height * to_light_;
  return std::any_of(casters_.begin(), casters_.begin() + count_, [&](const Caster& caster) {
    // If the whole axis does not reach the ball, no piece does.
    if (!reaches(caster, 0, kPieces, center, seen, height, radius)) return false;
    for (std::size_t k = 0; k < kPieces; ++k)
      if (reaches(caster, k, k + 1, center, seen, height, radius)) return true;
    return false;
  });
}

bool cursor_marks(const shared::FrameData& data, const glm::vec3& center, float radius) {
  if (data.cursor.w <= 0) return false;
  const glm::vec3 down(data.cursor_down), q = center - glm::vec3(data.cursor);
  const float below = glm::dot(q, down);
  // The ring surrounds the cursor's line. With its soft edge, it ends at less than twice its radius from the line.
  return below + radius > -data.cursor.w && glm::length(q - below * down) - radius < 2 * data.cursor.w;
}

ShadowMapBox shadow_map_box(const glm::dmat4& light_from_box, const glm::vec3& lo, const glm::vec3& hi) {
  ShadowMapBox box;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec2 p(light_from_box *
                      glm::dvec4(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z, 1));
    box.lo = glm::min(box.lo, p);
    box.hi = glm::max(box.hi, p);
  }
  return box;
}

float shadow_lookup_reach(const shared::FrameData& data) {
  // Sum of kOcclusionRadius, distance of the lookup point and filter width (lighting.glsl), divided by the map's width.
  return (2.2e-3f + 0.27e-3f + 4 * data.light_size.z) / data.light_size.x;
}

}  // namespace typodont::render

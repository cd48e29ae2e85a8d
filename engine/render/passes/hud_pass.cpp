#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "engine/render/passes/passes.h"
#include "render_font.h"
#include "shaders/hud_frag.h"
#include "shaders/hud_vert.h"

namespace typodont::render {

namespace {

struct Color {
  std::uint8_t r, g, b, a;
};
constexpr Color kInk{236, 240, 244, 255}, kFaint{150, 160, 172, 255}, kPanel{14, 17, 21, 185}, kTrack{60, 66, 74, 220};

/// Lays out quads in the user's coordinates: unit = half the picture's height, origin in the middle, y up.
struct Layout {
  std::vector<HudVertex> out;
  glm::dmat2 upright{1.0};
  double aspect = 1;  // width / height of the picture as the user sees it

  glm::dvec2 place(glm::dvec2 p) const { return upright * glm::dvec2(p.x / aspect, p.y); }

  void quad(glm::dvec2 lo, glm::dvec2 hi, glm::dvec2 atlas_lo, glm::dvec2 atlas_hi, Color c, double box_aspect) {
    const bool box = box_aspect > 0;
    const auto corner = [&](int x, int y) {
      const glm::dvec2 p = place({x ? hi.x : lo.x, y ? hi.y : lo.y});
      HudVertex v{};
      v.place[0] = static_cast<float>(p.x);
      v.place[1] = static_cast<float>(p.y);
      v.place[2] = static_cast<float>(x ? atlas_hi.x : atlas_lo.x);
      v.place[3] = static_cast<float>(y ? atlas_lo.y : atlas_hi.y);
      v.color[0] = c.r, v.color[1] = c.g, v.color[2] = c.b, v.color[3] = c.a;
      v.box[0] = x ? 1.0f : -1.0f;
      v.box[1] = y ? 1.0f : -1.0f;
      v.box[2] = static_cast<float>(box_aspect);
      v.box[3] = box ? 1.0f : 0.0f;
      return v;
    };
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) out.push_back(corner(x, y));
  }
  void box(glm::dvec2 lo, glm::dvec2 hi, Color c) {
    const double half = 0.5 * (hi.y - lo.y);
    const glm::dvec2 corner(std::min(0.028 / half, 0.95), 0);  // of the corners' rounding, in half heights
    quad(lo, hi, corner, corner, c, (hi.x - lo.x) / (hi.y - lo.y));
  }

  static const font::Glyph* glyph(int code) {
    for (const font::Glyph& g : font::kGlyphs)
      if (g.code == code) return &g;
    return nullptr;
  }
  /// Next character of UTF-8 text; what the font does not hold is shown as '?'.
  static const font::Glyph& next(std::string_view text, std::size_t& i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    int code = byte(i++);
    if (code >= 0xc0) {
      // Two or three bytes in all: dashes and the like have three.
      const std::size_t more = code < 0xe0 ? 1 : code < 0xf0 ? 2 : 0;
      const bool whole = more > 0 && i + more <= text.size();
      code = whole ? code & (more == 1 ? 0x1f : 0x0f) : '?';
      for (std::size_t k = 0; whole && k < more; ++k) code = code << 6 | (byte(i + k) & 0x3f);
      while (i < text.size() && (byte(i) & 0xc0) == 0x80) ++i;
    }
    const font::Glyph* g = glyph(code);
    return g ? *g : *glyph('?');
  }
  static double width(std::string_view text, double height) {
    double x = 0;
    for (std::size_t i = 0; i < text.size();) x += static_cast<double>(next(text, i).advance);
    return x * height / font::kSize;
  }
  void text(glm::dvec2 at, double height, std::string_view text, Color c) {
    const double s = height / font::kSize;
    for (std::size_t i = 0; i < text.size();) {
      const font::Glyph& g = next(text, i);
      if (g.w) {
        const glm::dvec2 lo{at.x + s * g.left, at.y - s * (g.top + g.h)}, hi{lo.x + s * g.w, lo.y + s * g.h};
        const glm::dvec2 size{font::kWidth, font::kHeight};
        quad(lo, hi, glm::dvec2(g.x, g.y) / size, glm::dvec2(g.x + g.w, g.y + g.h) / size, c, 0);
      }
      at.x += s * static_cast<double>(g.advance);
    }
  }
};

std::string speed_text(const Hud& hud) {
  return fmt::format("{:.0f} krpm", hud.speed_krpm);
}
std::string force_text(const Hud& hud) {
  return fmt::format("{:.2f} N", hud.force);
}
/// Of the bar, in steps that are smaller than a pixel on most screens.
double force_share(const Hud& hud) {
  constexpr double kSteps = 256;
  return hud.force_limit > 0 ? std::round(kSteps * std::clamp(hud.force / hud.force_limit, 0.0, 1.0)) / kSteps : 0.0;
}

Color force_color(double share) {
  // green to amber to red
  const double t = std::clamp(share, 0.0, 1.0);
  const glm::dvec3 a{88, 196, 140}, b{238, 188, 72}, c{232, 84, 66};
  const glm::dvec3 m = t < 0.6 ? glm::mix(a, b, t / 0.6) : glm::mix(b, c, (t - 0.6) / 0.4);
  return {static_cast<std::uint8_t>(m.r), static_cast<std::uint8_t>(m.g), static_cast<std::uint8_t>(m.b), 255};
}

}  // namespace

std::string HudPass::shown(const Hud& hud, glm::ivec2 size) {
  if (!hud.visible) return {};
  return fmt::format("{}\n{}\n{}\n{}\n{}\n{} {} {} {} {} {} {}", hud.tool, hud.hint, speed_text(hud), force_text(hud),
                     force_share(hud), hud.aspect, hud.upright[0].x, hud.upright[0].y, hud.upright[1].x,
                     hud.upright[1].y, size.x, size.y);
}

void HudPass::prepare(PassContext& context, int slot, const Hud& hud, glm::ivec2 size) {
  std::string says = shown(hud, size);
  std::string& said_before = said[static_cast<std::size_t>(slot)];
  if (says == said_before) return;
  said_before = std::move(says);
  count[static_cast<std::size_t>(slot)] = 0;
  if (!hud.visible) return;
  if (!atlas.image) {
    atlas = gpu::Image::create(context.device, {.size = {font::kWidth, font::kHeight},
                                                .format = VK_FORMAT_R8_UNORM,
                                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    gpu::upload(context.device, atlas, font::kAtlas);
  }

  Layout l;
  l.upright = hud.upright;
  const double pixels = hud.aspect > 0 ? hud.aspect : static_cast<double>(size.x) / size.y;
  const bool turned = std::abs(hud.upright[0].x) < 0.5;  // the panel stands on its side
  l.aspect = turned ? 1 / pixels : pixels;
  const double h = 0.062, margin = 0.05, pad = 0.035;
  const std::string speed = speed_text(hud);
  const double wide = std::max(0.74, Layout::width(hud.tool, h) + Layout::width(speed, h) + 2 * pad + h);
  // Panel at the lower left: tool, speed, force.
  const glm::dvec2 lo{-l.aspect + margin, -1 + margin}, hi{lo.x + wide, lo.y + 0.245};
  l.box(lo, hi, kPanel);
  const double y1 = hi.y - pad - 0.75 * h, y2 = y1 - 1.35 * h;
  l.text({lo.x + pad, y1}, h, hud.tool, kInk);
  l.text({hi.x - pad - Layout::width(speed, h), y1}, h, speed, hud.speed_krpm > 0 ? kInk : kFaint);
  const double share = force_share(hud);
  const std::string force = force_text(hud);
  const double bar_end = hi.x - pad - Layout::width("00.00 N", h) - 0.02;
  const glm::dvec2 bar_lo{lo.x + pad, y2 + 0.0}, bar_hi{bar_end, y2 + 0.5 * h};
  l.box(bar_lo, bar_hi, kTrack);
  if (share > 0.005) {
    const double end = bar_lo.x + std::max(share * (bar_hi.x - bar_lo.x), 0.4 * h);
    l.box(bar_lo, {end, bar_hi.y}, force_color(share));
  }
  l.text({hi.x - pad - Layout::width(force, h), y2}, h, force, kInk);
  if (!hud.hint.empty()) {
    const double w = Layout::width(hud.hint, h);
    l.box({-0.5 * w - pad, 1 - margin - 1.7 * h}, {0.5 * w + pad, 1 - margin}, kPanel);
    l.text({-0.5 * w, 1 - margin - 1.15 * h}, h, hud.hint, kInk);
  }

  gpu::Buffer& buffer =
      vertices.at_least(context.device, slot, l.out.size() * sizeof(HudVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  std::memcpy(buffer.memory.mapped, l.out.data(), l.out.size() * sizeof(HudVertex));
  count[static_cast<std::size_t>(slot)] = static_cast<std::uint32_t>(l.out.size());
}

void HudPass::mark(int slot, const glm::ivec2& size, Tiles& tiles) const {
  const std::uint32_t corners = count[static_cast<std::size_t>(slot)];
  const HudVertex* v = corners ? vertices.buffers[static_cast<std::size_t>(slot)].mapped<HudVertex>() : nullptr;
  for (std::uint32_t i = 0; i + 5 < corners; i += 6) {
    glm::vec2 lo(1e9f), hi(-1e9f);
    for (std::uint32_t k = 0; k < 6; ++k) {
      const glm::vec2 p(v[i + k].place[0], -v[i + k].place[1]);
      lo = glm::min(lo, p);
      hi = glm::max(hi, p);
    }
    const glm::vec2 edge(size);
    const glm::ivec2 a(glm::clamp((0.5f + 0.5f * lo) * edge - 1.0f, glm::vec2(0), edge)),
        b(glm::clamp((0.5f + 0.5f * hi) * edge + 2.0f, glm::vec2(0), edge));
    tiles.mark({a.x, a.y, b.x - a.x, b.y - a.y});
  }
}

void HudPass::record(PassContext& context, VkCommandBuffer commands, int slot, FrameStats& stats) {
  const std::uint32_t corners = count[static_cast<std::size_t>(slot)];
  if (!corners) return;
  if (!pipeline) {
    gpu::PipelineOptions o = context.scene_pipeline(kSpirv_hud_vert, kSpirv_hud_frag);
    o.bindings = {{0, sizeof(HudVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
    o.attributes = {{0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(HudVertex, place)},
                    {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(HudVertex, color)},
                    {0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(HudVertex, box)}};
    o.cull = VK_CULL_MODE_NONE;
    o.depth_write = false;
    o.depth_compare = VK_COMPARE_OP_LESS;  // before everything but what is not drawn at all (HiddenPass, MaskPass)
    o.blend = true;
    pipeline = gpu::create_pipeline(context.device, o);
  }
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  const VkDeviceSize zero = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices.buffers[static_cast<std::size_t>(slot)].buffer, &zero);
  vkCmdDraw(commands, corners, 1, 0, 0);
  ++stats.commands;
}

void HudPass::destroy(gpu::Device& device) {
  destroy_pipeline(device, pipeline);
  atlas.destroy(device);
  vertices.destroy(device);
}

}  // namespace typodont::render

#include "engine/display/writing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "text_font.h"

namespace typodont::display {

namespace {

using glm::dvec2;
using glm::ivec2;

struct Color {
  std::uint8_t r, g, b, a;
};
constexpr Color kInk{236, 240, 244, 255}, kFaint{150, 160, 172, 255}, kPanel{14, 17, 21, 200}, kTrack{60, 66, 74, 220};
constexpr Color kAmber{255, 190, 60, 255}, kOnAmber{14, 17, 21, 255};  // contrast 11:1

// In units of half the picture's height: height of letters, margin, space inside a panel, radius of its corners,
// smallest width of a panel.
constexpr double kLetters = 0.062, kMargin = 0.05, kPad = 0.035, kCorner = 0.028, kMinPanel = 0.74;
constexpr double kMinLetters = 13;  // pixels, smallest height of the letters
// Smallest height of Chinese characters, pixels.
constexpr double kMinChinese = 19;
constexpr int kFirstChinese = 0x3000;  // smallest code of Chinese characters and punctuation
constexpr std::string_view kGap = "   ";

const font::Glyph* glyph(int code) {
  const auto* const at = std::lower_bound(std::begin(font::kGlyphs), std::end(font::kGlyphs), code,
                                          [](const font::Glyph& g, int wanted) { return g.code < wanted; });
  return at != std::end(font::kGlyphs) && at->code == code ? at : nullptr;
}

/// Code of the UTF-8 character at i; moves i to the next character. Invalid bytes give '?'.
int next_code(std::string_view text, std::size_t& i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  int code = byte(i++);
  if (code >= 0xc0) {
    // Number of further bytes; characters of two or three bytes are supported.
    const std::size_t more = code < 0xe0 ? 1 : code < 0xf0 ? 2 : 0;
    const bool whole = more > 0 && i + more <= text.size();
    code = whole ? code & (more == 1 ? 0x1f : 0x0f) : '?';
    for (std::size_t k = 0; whole && k < more; ++k) code = code << 6 | (byte(i + k) & 0x3f);
    while (i < text.size() && (byte(i) & 0xc0) == 0x80) ++i;
  }
  return code;
}

/// Glyph of the next character, or of '?' if the font lacks it.
const font::Glyph& next(std::string_view text, std::size_t& i) {
  const font::Glyph* g = glyph(next_code(text, i));
  return g ? *g : *glyph('?');
}

bool has_chinese(std::string_view text) {
  for (std::size_t i = 0; i < text.size();)
    if (next_code(text, i) >= kFirstChinese) return true;
  return false;
}

/// Breaks a text into lines of at most `most` width, only at the separator `gap`.
std::vector<std::string> broken_at(std::string_view gap, std::string_view text, double most, double height) {
  std::vector<std::string> lines;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(gap, from), text.size());
    const std::string_view part = text.substr(from, end - from);
    from = end + gap.size();
    if (part.empty()) continue;
    if (!lines.empty() && text_width(lines.back(), height) + text_width(gap, height) + text_width(part, height) <= most)
      lines.back().append(gap).append(part);
    else
      lines.emplace_back(part);
  }
  return lines;
}

/// Breaks before Chinese characters. Other characters stay together, and punctuation stays with the character before
/// it.
std::vector<std::string> broken_between_characters(std::string_view text, double most, double height) {
  constexpr std::string_view kStays = "，。：；、！？）";
  std::vector<std::string> lines(1);
  for (std::size_t i = 0; i < text.size();) {
    // The next unit: a Chinese character with its punctuation, or a run of other characters.
    const std::size_t from = i;
    const bool chinese = next_code(text, i) >= kFirstChinese;
    for (std::size_t end = i; i < text.size(); i = end) {
      const int code = next_code(text, end);
      const bool stays = kStays.find(text.substr(i, end - i)) != std::string_view::npos && code >= kFirstChinese;
      if (!stays && (chinese || code >= kFirstChinese)) break;
    }
    const std::string_view unit = text.substr(from, i - from);
    if (!lines.back().empty() && text_width(lines.back(), height) + text_width(unit, height) > most)
      lines.emplace_back();
    lines.back().append(unit);
  }
  return lines;
}

std::vector<std::string> lines_of(std::string_view hint, double most, double height) {
  std::vector<std::string> lines;
  for (const std::string& line : broken_at(kGap, hint, most, height)) {
    if (text_width(line, height) <= most) {
      lines.push_back(line);
      continue;
    }
    for (const std::string& piece : broken_at(" ", line, most, height)) {
      if (text_width(piece, height) <= most)
        lines.push_back(piece);
      else
        for (std::string& part : broken_between_characters(piece, most, height)) lines.push_back(std::move(part));
    }
  }
  return lines;
}

std::string force_text(const Hud& hud) {
  if (!hud.force_shown) return "";
  std::string text = fmt::format("{:.2f} N", hud.force);
  std::replace(text.begin(), text.end(), '.', hud.words.decimal);
  return text;
}
/// Force as a fraction of the limit, rounded to steps smaller than a pixel of the bar.
double force_fraction(const Hud& hud) {
  constexpr double kSteps = 256;
  return hud.force_shown && hud.force_limit > 0
             ? std::round(kSteps * std::clamp(hud.force / hud.force_limit, 0.0, 1.0)) / kSteps
             : 0.0;
}

Color force_color(double fraction) {
  // the colour goes from green over amber to red
  const double t = std::clamp(fraction, 0.0, 1.0);
  const glm::dvec3 a{88, 196, 140}, b{238, 188, 72}, c{232, 84, 66};
  const glm::dvec3 m = t < 0.6 ? glm::mix(a, b, t / 0.6) : glm::mix(b, c, (t - 0.6) / 0.4);
  return {static_cast<std::uint8_t>(m.r), static_cast<std::uint8_t>(m.g), static_cast<std::uint8_t>(m.b), 255};
}

/// Converts user coordinates (units of half the height, from the middle, y up for the reader) to pixels.
struct Map {
  ivec2 place;
  glm::dmat2 upright;
  double aspect;  // width divided by height of the picture that the user sees

  dvec2 to_pixels(const dvec2& p) const {
    const dvec2 q = upright * dvec2(p.x / aspect, p.y);
    return {(q.x + 1) / 2 * place.x, (1 - q.y) / 2 * place.y};
  }
  dvec2 to_user(const dvec2& pixel) const {
    const dvec2 q(2 * pixel.x / place.x - 1, 1 - 2 * pixel.y / place.y);
    const dvec2 p = glm::transpose(upright) * q;
    return {p.x * aspect, p.y};
  }
};

/// Draws into one text panel, in user coordinates.
class Painter {
 public:
  Painter(const Map& map, const dvec2& lo, const dvec2& hi, const Color& background) : map_(map) {
    panel_.box = box_of(lo, hi, {ivec2(0), map.place});
    const auto pixels = static_cast<std::size_t>(panel_.box.size.x) * static_cast<std::size_t>(panel_.box.size.y);
    panel_.rgba.assign(4 * pixels, 0);
    rounded(lo, hi, background);
  }

  /// Draws a box with rounded corners.
  void rounded(const dvec2& lo, const dvec2& hi, const Color& color) {
    const dvec2 middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    const double corner = std::min(kCorner, 0.95 * half.y);
    fill(lo, hi, color, [&](const dvec2& p) {
      const dvec2 q = glm::max(glm::abs(p - middle) - half + corner, dvec2(0));
      return corner - glm::length(q);
    });
  }

  void text(dvec2 at, double height, std::string_view text, const Color& color) {
    const double s = height / font::kSize;
    for (std::size_t i = 0; i < text.size();) {
      const font::Glyph& g = next(text, i);
      if (g.w > 0) {
        const dvec2 lo{at.x + s * g.left, at.y - s * (g.top + g.h)}, hi{lo.x + s * g.w, lo.y + s * g.h};
        // Glyphs are distance fields, which are sharp at every size (Green 2007).
        fill(lo, hi, color, [&](const dvec2& p) { return distance(g, (p.x - lo.x) / s, (hi.y - p.y) / s); });
      }
      at.x += s * static_cast<double>(g.advance);
    }
  }

  Writing::Panel take() { return std::move(panel_); }

 private:
  /// Returns the pixels that a rectangle may cover.
  WritingBox box_of(const dvec2& lo, const dvec2& hi, const WritingBox& within) const {
    const dvec2 a = map_.to_pixels(lo), b = map_.to_pixels(hi);
    const ivec2 from(glm::floor(glm::min(a, b))), to(glm::ceil(glm::max(a, b)));
    const ivec2 low = glm::clamp(from, within.lo, within.lo + within.size),
                high = glm::clamp(to, within.lo, within.lo + within.size);
    return {low, high - low};
  }

  /// Distance from the glyph's outline, positive inside; x, y in pixels of the atlas.
  static double distance(const font::Glyph& g, double x, double y) {
    const auto at = [&](int i, int j) {
      i = std::clamp(i, 0, g.w - 1), j = std::clamp(j, 0, g.h - 1);
      return font::kAtlas[static_cast<std::size_t>((g.y + j) * font::kWidth + g.x + i)] / 255.0;
    };
    const double u = x - 0.5, v = y - 0.5;
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
    const double a = u - i, b = v - j;
    return (1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) + b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1)) -
           0.5;
  }

  /// Fills the area where `inside` > 0, with a smooth edge of one pixel.
  template <class Inside>
  void fill(const dvec2& lo, const dvec2& hi, const Color& color, const Inside& inside) {
    const WritingBox box = box_of(lo, hi, panel_.box);
    // `inside` is evaluated for one more pixel on each side, to compute its slope.
    const int stride = box.size.x + 2;
    field_.resize(static_cast<std::size_t>(stride) * static_cast<std::size_t>(box.size.y + 2));
    for (int y = 0; y < box.size.y + 2; ++y)
      for (int x = 0; x < stride; ++x)
        field_[static_cast<std::size_t>(y * stride + x)] = inside(map_.to_user(dvec2(box.lo + ivec2(x, y)) - 0.5));
    for (int y = 0; y < box.size.y; ++y) {
      const double* d = field_.data() + (y + 1) * stride + 1;
      std::uint8_t* out = panel_.rgba.data() + 4 * (static_cast<std::size_t>(box.lo.y + y - panel_.box.lo.y) *
                                                        static_cast<std::size_t>(panel_.box.size.x) +
                                                    static_cast<std::size_t>(box.lo.x - panel_.box.lo.x));
      for (int x = 0; x < box.size.x; ++x, ++d, out += 4) {
        const double slope = 0.5 * (std::abs(d[1] - d[-1]) + std::abs(d[stride] - d[-stride]));
        const double covered = std::clamp(0.5 + *d / std::max(slope, 1e-6), 0.0, 1.0) * color.a / 255.0;
        if (covered <= 0) continue;
        const std::array<double, 4> source{color.r * covered, color.g * covered, color.b * covered, 255 * covered};
        for (std::size_t c = 0; c < 4; ++c)
          out[c] = static_cast<std::uint8_t>(source[c] + (1 - covered) * out[c] + 0.5);
      }
    }
  }

  const Map& map_;
  Writing::Panel panel_;
  std::vector<double> field_;  // buffer of fill(), reused by every call
};

}  // namespace

std::string spindle_text(double krpm, const HudWords& words) {
  // Below this speed (krpm), values are rounded to 10 rpm (implant drills, reamers).
  constexpr double kSlow = 10;
  const bool slow = krpm < kSlow;
  return fmt::format(fmt::runtime(slow ? words.rpm : words.krpm),
                     fmt::format("{:.0f}", slow ? 10 * std::round(100 * krpm) : krpm));
}

double text_width(std::string_view text, double height) {
  double x = 0;
  for (std::size_t i = 0; i < text.size();) x += static_cast<double>(next(text, i).advance);
  return x * height / font::kSize;
}

void write_line(std::uint8_t* rgba, const ivec2& size, const dvec2& at, double height, std::string_view text,
                const glm::u8vec3& color) {
  const Map map{size, glm::dmat2(1), static_cast<double>(size.x) / size.y};
  const dvec2 lo = map.to_user(at + dvec2(-height, height)),
              hi = map.to_user(at + dvec2(text_width(text, height) + height, -height));
  Painter line(map, lo, hi, {0, 0, 0, 0});
  line.text(map.to_user(at), 2 * height / size.y, text, {color.r, color.g, color.b, 255});
  Writing::lay_over(line.take(), rgba, 4 * static_cast<std::size_t>(size.x), ivec2(0), false);
}

bool can_write(std::string_view text) {
  for (std::size_t i = 0; i < text.size();)
    if (!glyph(next_code(text, i))) return false;
  return true;
}

namespace {

/// Returns the number of pixel rows of the atlas in which the glyph is visible, without the margin of its box.
double ink_rows(const font::Glyph& g) {
  int rows = 0;
  for (int j = 0; j < g.h; ++j) {
    const auto* const row = font::kAtlas + (g.y + j) * font::kWidth + g.x;
    rows += std::any_of(row, row + g.w, [](auto distance) { return distance >= 128; });
  }
  return rows;
}

}  // namespace

double readable_letters(const DisplayRig& rig) {
  if (rig.kind != DisplayKind::kMirror) return 0;
  const Screen screen = rig.mirror ? reflect(*rig.mirror, rig.screen) : rig.screen;
  const dvec3 up = screen.upper_left - screen.lower_left;
  const dvec3 middle = 0.5 * (screen.upper_left + screen.lower_right), sight = middle - rig.head.eye_center;
  const double distance = glm::length(sight);
  // Vertical extent of the picture perpendicular to the line of sight, m.
  const dvec3 seen = up - sight * (glm::dot(up, sight) / (distance * distance));
  // Angle of half the picture's height at the eye, rad.
  const double half_height = 0.5 * glm::length(seen) / distance;
  // Height of the letter x, divided by `font::kSize`.
  const double x_height = ink_rows(*glyph('x')) / font::kSize;
  return kMinXHeight / (x_height * half_height);
}

std::string Writing::shown(const Hud& hud, ivec2 place) {
  if (!hud.visible) return {};
  return fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{} {} {} {} {} {} {} {}", hud.tool, hud.hint, hud.warning,
                     spindle_text(hud.speed_krpm, hud.words), force_text(hud), force_fraction(hud), hud.aspect,
                     hud.min_letters, hud.upright[0].x, hud.upright[0].y, hud.upright[1].x, hud.upright[1].y, place.x,
                     place.y);
}

std::vector<WritingBox> Writing::write(const Hud& hud, ivec2 place) {
  std::string says = shown(hud, place);
  if (says == shown_) return {};
  shown_ = std::move(says);
  std::vector<WritingBox> changed;
  for (const Panel& panel : panels_) changed.push_back(panel.box);
  panels_.clear();
  if (!hud.visible) return changed;

  const double pixels = hud.aspect > 0 ? hud.aspect : static_cast<double>(place.x) / place.y;
  const bool turned = std::abs(hud.upright[0].x) < 0.5;  // true: the display panel is mounted on its side
  const Map map{place, hud.upright, turned ? 1 / pixels : pixels};
  const std::string speed = spindle_text(hud.speed_krpm, hud.words), force = force_text(hud);

  // Height of letters: in proportion to the picture, but readable, and not wider than the picture.
  const double least = has_chinese(hud.tool + speed + hud.hint + hud.warning) ? kMinChinese : kMinLetters;
  double h = std::max({kLetters, hud.min_letters, 2 * least / (turned ? place.x : place.y)});
  const double room = 2 * (map.aspect - kMargin - kPad);
  const auto first_line = [&](double height) {
    return text_width(hud.tool, height) + text_width(speed, height) + height;
  };
  h *= std::min(1.0, room / first_line(h));

  if (!hud.tool.empty()) {
    // The panel in the lower left corner: tool, speed, force.
    const double wide = std::min(std::max(kMinPanel, first_line(h) + 2 * kPad), room + 2 * kPad);
    const dvec2 lo{-map.aspect + kMargin, -1 + kMargin},
        hi{lo.x + wide, lo.y + 2 * kPad + (hud.force_shown ? 2.85 : 1.5) * h};
    Painter status(map, lo, hi, kPanel);
    const double y1 = hi.y - kPad - 0.75 * h, y2 = y1 - 1.35 * h;
    status.text({lo.x + kPad, y1}, h, hud.tool, kInk);
    status.text({hi.x - kPad - text_width(speed, h), y1}, h, speed, hud.speed_krpm > 0 ? kInk : kFaint);
    const double fraction = force_fraction(hud);
    const dvec2 bar_lo{lo.x + kPad, y2}, bar_hi{hi.x - kPad - text_width("00.00 N", h) - 0.02, y2 + 0.5 * h};
    if (hud.force_shown && bar_hi.x > bar_lo.x) {
      status.rounded(bar_lo, bar_hi, kTrack);
      const double end = bar_lo.x + std::max(fraction * (bar_hi.x - bar_lo.x), 0.4 * h);
      if (fraction > 0.005) status.rounded(bar_lo, {end, bar_hi.y}, force_color(fraction));
    }
    status.text({hi.x - kPad - text_width(force, h), y2}, h, force, kInk);
    panels_.push_back(status.take());
  }

  // The panels at the top centre: the hints, and below them the warning.
  double top = 1 - kMargin;
  const auto write_lines = [&](const std::string& text, const Color& background, const Color& ink) {
    const std::vector<std::string> lines = lines_of(text, room, h);
    if (lines.empty()) return;
    double widest = 0;
    for (const std::string& line : lines) widest = std::max(widest, text_width(line, h));
    const double line_height = 1.3 * h, bottom = top - 0.4 * h - static_cast<double>(lines.size()) * line_height;
    Painter panel(map, {-0.5 * widest - kPad, bottom}, {0.5 * widest + kPad, top}, background);
    for (std::size_t i = 0; i < lines.size(); ++i)
      panel.text({-0.5 * text_width(lines[i], h), top - 1.15 * h - static_cast<double>(i) * line_height}, h, lines[i],
                 ink);
    panels_.push_back(panel.take());
    top = bottom - kMargin;
  };
  write_lines(hud.hint, kPanel, kInk);
  write_lines(hud.warning, kAmber, kOnAmber);
  for (const Panel& panel : panels_) changed.push_back(panel.box);
  return changed;
}

void Writing::lay_over(const Panel& panel, std::uint8_t* pixels, std::size_t pitch, ivec2 place, bool blue_first) {
  const ivec2 at = place + panel.box.lo;
  const std::uint8_t* ink = panel.rgba.data();
  for (int y = 0; y < panel.box.size.y; ++y) {
    std::uint8_t* out = pixels + static_cast<std::size_t>(at.y + y) * pitch + 4 * static_cast<std::size_t>(at.x);
    for (int x = 0; x < panel.box.size.x; ++x, out += 4, ink += 4) {
      const unsigned left = 255u - ink[3];
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t to = blue_first ? 2 - c : c;
        out[to] = static_cast<std::uint8_t>(ink[c] + (out[to] * left + 127) / 255);
      }
    }
  }
}

}  // namespace typodont::display

#include "engine/render/picture_text.h"

#include <algorithm>
#include <cmath>

#include "text_font.h"

namespace typodont::render {

namespace {

const font::Glyph& glyph_of(char c) {
  const font::Glyph* question = nullptr;
  for (const font::Glyph& g : font::kGlyphs) {
    if (g.code == static_cast<unsigned char>(c) && g.code < 127) return g;
    if (g.code == '?') question = &g;
  }
  return *question;
}

/// Value of the font's distance field at p (pixels of the atlas), 0 to 1; 0.5 at the edge of a letter.
double sampled(glm::dvec2 p) {
  const auto pixel = [](int x, int y) {
    x = std::clamp(x, 0, font::kWidth - 1);
    y = std::clamp(y, 0, font::kHeight - 1);
    return font::kAtlas[y * font::kWidth + x] / 255.0;
  };
  p -= 0.5;
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
  const double u = p.x - x, v = p.y - y;
  return (1 - v) * ((1 - u) * pixel(x, y) + u * pixel(x + 1, y)) +
         v * ((1 - u) * pixel(x, y + 1) + u * pixel(x + 1, y + 1));
}

}  // namespace

double text_width(std::string_view text, double height) {
  double width = 0;
  for (const char c : text) width += static_cast<double>(glyph_of(c).advance);
  return width * height / font::kSize;
}

void write_text(Picture& picture, glm::dvec2 at, double height, std::string_view text, glm::u8vec3 color) {
  const double s = height / font::kSize;
  // The blurred edge of a letter is ten pixels wide in the atlas (bake_font), and should be one pixel wide here.
  const double steep = 10.0 * s;
  for (const char c : text) {
    const font::Glyph& g = glyph_of(c);
    const glm::dvec2 lo{at.x + s * g.left, at.y + s * g.top};
    const glm::ivec2 from(glm::floor(lo)), to(glm::ceil(lo + s * glm::dvec2(g.w, g.h)));
    for (int y = std::max(from.y, 0); y < std::min(to.y, picture.size.y); ++y) {
      for (int x = std::max(from.x, 0); x < std::min(to.x, picture.size.x); ++x) {
        const glm::dvec2 in = (glm::dvec2(x, y) + 0.5 - lo) / s;
        if (in.x < 0 || in.y < 0 || in.x > g.w || in.y > g.h) continue;
        const double cover = std::clamp(0.5 + (sampled(in + glm::dvec2(g.x, g.y)) - 0.5) * steep, 0.0, 1.0);
        std::uint8_t* pixel =
            picture.rgba.data() +
            4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.size.x) + static_cast<std::size_t>(x));
        for (int k = 0; k < 3; ++k)
          pixel[k] = static_cast<std::uint8_t>(std::lround(pixel[k] + cover * (color[k] - pixel[k])));
      }
    }
    at.x += s * static_cast<double>(g.advance);
  }
}

}  // namespace typodont::render

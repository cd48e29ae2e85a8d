#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "calibration/guided_capture.h"

namespace typodont::calibration {

namespace {

// A letter of 5×7 pixels: seven rows of five bits, each as two hexadecimal digits.
struct Glyph {
  char character;
  unsigned char rows[7];
};
constexpr Glyph kFont[] = {{'A', {0x0E, 0x11, 0x11, 0x1F, 0x11, 0x11, 0x11}},
                           {'B', {0x1E, 0x11, 0x11, 0x1E, 0x11, 0x11, 0x1E}},
                           {'C', {0x0E, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0E}},
                           {'D', {0x1C, 0x12, 0x11, 0x11, 0x11, 0x12, 0x1C}},
                           {'E', {0x1F, 0x10, 0x10, 0x1E, 0x10, 0x10, 0x1F}},
                           {'F', {0x1F, 0x10, 0x10, 0x1E, 0x10, 0x10, 0x10}},
                           {'G', {0x0E, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0F}},
                           {'H', {0x11, 0x11, 0x11, 0x1F, 0x11, 0x11, 0x11}},
                           {'I', {0x0E, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0E}},
                           {'J', {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0C}},
                           {'K', {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11}},
                           {'L', {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1F}},
                           {'M', {0x11, 0x1B, 0x15, 0x15, 0x11, 0x11, 0x11}},
                           {'N', {0x11, 0x11, 0x19, 0x15, 0x13, 0x11, 0x11}},
                           {'O', {0x0E, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0E}},
                           {'P', {0x1E, 0x11, 0x11, 0x1E, 0x10, 0x10, 0x10}},
                           {'Q', {0x0E, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0D}},
                           {'R', {0x1E, 0x11, 0x11, 0x1E, 0x14, 0x12, 0x11}},
                           {'S', {0x0F, 0x10, 0x10, 0x0E, 0x01, 0x01, 0x1E}},
                           {'T', {0x1F, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04}},
                           {'U', {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0E}},
                           {'V', {0x11, 0x11, 0x11, 0x11, 0x11, 0x0A, 0x04}},
                           {'W', {0x11, 0x11, 0x11, 0x15, 0x15, 0x15, 0x0A}},
                           {'X', {0x11, 0x11, 0x0A, 0x04, 0x0A, 0x11, 0x11}},
                           {'Y', {0x11, 0x11, 0x11, 0x0A, 0x04, 0x04, 0x04}},
                           {'Z', {0x1F, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1F}},
                           {'0', {0x0E, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0E}},
                           {'1', {0x04, 0x0C, 0x04, 0x04, 0x04, 0x04, 0x0E}},
                           {'2', {0x0E, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1F}},
                           {'3', {0x1F, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0E}},
                           {'4', {0x02, 0x06, 0x0A, 0x12, 0x1F, 0x02, 0x02}},
                           {'5', {0x1F, 0x10, 0x1E, 0x01, 0x01, 0x11, 0x0E}},
                           {'6', {0x06, 0x08, 0x10, 0x1E, 0x11, 0x11, 0x0E}},
                           {'7', {0x1F, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
                           {'8', {0x0E, 0x11, 0x11, 0x0E, 0x11, 0x11, 0x0E}},
                           {'9', {0x0E, 0x11, 0x11, 0x0F, 0x01, 0x02, 0x0C}},
                           {'.', {0, 0, 0, 0, 0, 0x0C, 0x0C}},
                           {',', {0, 0, 0, 0, 0x0C, 0x04, 0x08}},
                           {'(', {0x02, 0x04, 0x08, 0x08, 0x08, 0x04, 0x02}},
                           {')', {0x08, 0x04, 0x02, 0x02, 0x02, 0x04, 0x08}},
                           {':', {0, 0x0C, 0x0C, 0, 0x0C, 0x0C, 0}},
                           {';', {0, 0x0C, 0x0C, 0, 0x0C, 0x04, 0x08}},
                           {'-', {0, 0, 0, 0x1F, 0, 0, 0}},
                           {'/', {0, 0x01, 0x02, 0x04, 0x08, 0x10, 0}}};

}  // namespace

Picture prompt_picture(const Prompt& prompt, int width, int height, bool mirrored, bool upside_down) {
  Picture picture{width, height,
                  std::vector<unsigned char>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 16)};
  const auto set = [&](int x, int y, unsigned char grey) {
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    picture.grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = grey;
  };
  // Breaks the text into lines at its spaces. The lines are near the top of the picture; only they are mirrored.
  const int scale = std::max(1, width / 420), line_cells = std::max(8, width / (6 * scale) - 4);
  std::vector<std::string> lines(1);
  std::string_view rest = prompt.text;
  while (!rest.empty()) {
    const auto space = rest.find(' ');
    const std::string word(rest.substr(0, space));
    if (!lines.back().empty() && static_cast<int>(lines.back().size() + 1 + word.size()) > line_cells)
      lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    rest = space == std::string_view::npos ? std::string_view{} : rest.substr(space + 1);
  }
  int top = height / 4;
  for (const std::string& line : lines) {
    int left = (width - static_cast<int>(line.size()) * 6 * scale) / 2;
    for (const char character : line) {
      const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(character)));
      const auto glyph =
          std::find_if(std::begin(kFont), std::end(kFont), [&](const Glyph& g) { return g.character == upper; });
      for (int pixel = 0; glyph != std::end(kFont) && pixel < 35 * scale * scale; ++pixel) {
        const int x = pixel % (5 * scale), y = pixel / (5 * scale);
        if (!(glyph->rows[y / scale] >> (4 - x / scale) & 1)) continue;
        set(mirrored ? width - 1 - (left + x) : left + x, upside_down ? height - 1 - (top + y) : top + y, 230);
      }
      left += 6 * scale;
    }
    top += 10 * scale;
  }
  const auto cross = [&](const PanelPoint& p) {
    const int x = static_cast<int>(std::lround(p.u * (width - 1))),
              y = static_cast<int>(std::lround((1 - p.v) * (height - 1)));
    for (int i = -12 * scale; i <= 12 * scale; ++i) {
      for (int thick = -scale / 2; thick <= scale / 2; ++thick) set(x + i, y + thick, 255), set(x + thick, y + i, 255);
    }
  };
  const auto ring = [&](const PanelPoint& p) {
    const double x = p.u * (width - 1), y = (1 - p.v) * (height - 1), radius = 14.0 * scale;
    const int steps = 80 * scale;
    for (int i = 0; i < steps; ++i) {
      const double angle = 6.283185307179586 * i / steps;
      for (int thick = 0; thick <= scale; ++thick) {
        set(static_cast<int>(std::lround(x + (radius + thick) * std::cos(angle))),
            static_cast<int>(std::lround(y + (radius + thick) * std::sin(angle))), 200);
      }
    }
  };
  if (prompt.astray && prompt.left_eye) ring(prompt.astray->left);
  if (prompt.astray && prompt.right_eye) ring(prompt.astray->right);
  if (prompt.mark) cross(*prompt.mark);
  if (prompt.dots && prompt.left_eye) cross(prompt.dots->left);
  if (prompt.dots && prompt.right_eye) cross(prompt.dots->right);
  return picture;
}

}  // namespace typodont::calibration

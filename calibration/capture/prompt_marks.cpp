#include <algorithm>
#include <cmath>

#include "calibration/guided_capture.h"

namespace typodont::calibration {

Picture prompt_marks(const Prompt& prompt, int width, int height) {
  Picture picture{width, height,
                  std::vector<unsigned char>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0)};
  const int scale = std::max(1, width / 420);
  const auto set = [&](int x, int y, unsigned char grey) {
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    picture.grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = grey;
  };
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

#include "engine/app/picture/packing_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace typodont {

namespace {

constexpr double kPictureMargin = 1.05;  // width of the picture, in widths of the sphere packing
const dvec3 kLight = glm::normalize(dvec3(-0.45, -0.75, 0.6));
constexpr double kAmbient = 0.25;  // fraction of the colour that is visible in shadow

/// Draws spheres with centres at y >= `front` in a square of the picture that begins at pixel column `left`.
void draw(render::Picture& picture, int left, const SpherePacking& packing, const MaterialTable& materials,
          const dvec3& middle, double metres_per_pixel, double front) {
  const int n = picture.size.y;
  std::vector<double> nearest(static_cast<std::size_t>(n) * static_cast<std::size_t>(n),
                              std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < packing.size(); ++i) {
    const dvec3 c = packing.center[i];
    if (c.y < front) continue;
    const double r = packing.radius[i];
    const double u = (c.x - middle.x) / metres_per_pixel + 0.5 * n, v = 0.5 * n - (c.z - middle.z) / metres_per_pixel;
    const double reach = r / metres_per_pixel;
    const dvec3 color = materials[static_cast<std::size_t>(packing.tissue[i])].color;
    const auto first = [&](double at) { return std::max(0, static_cast<int>(std::floor(at - reach))); };
    const auto last = [&](double at) { return std::min(n - 1, static_cast<int>(std::ceil(at + reach))); };
    for (int y = first(v); y <= last(v); ++y) {
      for (int x = first(u); x <= last(u); ++x) {
        const double dx = (x + 0.5 - u) * metres_per_pixel, dz = -(y + 0.5 - v) * metres_per_pixel;
        const double rest = r * r - dx * dx - dz * dz;
        if (rest < 0) continue;
        const double toward = std::sqrt(rest), depth = c.y - toward;
        double& kept = nearest[static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x)];
        if (depth >= kept) continue;
        kept = depth;
        const double lit = std::max(0.0, glm::dot(dvec3(dx, -toward, dz) / r, kLight));
        std::uint8_t* pixel =
            picture.rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.size.x) +
                                       static_cast<std::size_t>(left + x));
        for (int k = 0; k < 3; ++k) {
          pixel[k] =
              static_cast<std::uint8_t>(255 * std::clamp(color[k] * (kAmbient + (1 - kAmbient) * lit), 0.0, 1.0) + 0.5);
        }
      }
    }
  }
}

}  // namespace

render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels) {
  dvec3 lo(std::numeric_limits<double>::infinity()), hi(-lo);
  for (std::size_t i = 0; i < packing.size(); ++i) {
    lo = glm::min(lo, packing.center[i] - packing.radius[i]);
    hi = glm::max(hi, packing.center[i] + packing.radius[i]);
  }
  const dvec3 middle = 0.5 * (lo + hi);
  const double scale = kPictureMargin * std::max(hi.x - lo.x, hi.z - lo.z) / pixels;
  render::Picture picture;
  picture.size = {2 * pixels, pixels};
  picture.rgba.resize(static_cast<std::size_t>(8) * static_cast<std::size_t>(pixels) *
                      static_cast<std::size_t>(pixels));
  for (std::size_t i = 0; i < picture.rgba.size(); ++i) picture.rgba[i] = i % 4 == 3 ? 255 : 24;
  draw(picture, 0, packing, materials, middle, scale, -std::numeric_limits<double>::infinity());
  draw(picture, pixels, packing, materials, middle, scale, middle.y);
  return picture;
}

}  // namespace typodont

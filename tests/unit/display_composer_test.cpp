// Tests the composition of the eyes' pictures on the CPU against exact bilinear interpolation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "engine/display/compose/by_processor.h"

namespace typodont::display {
namespace {

/// Value of a picture at (u, v) in pixels, by bilinear interpolation. Positions beyond the outermost pixel centres get
/// the values at the edge.
double exact(const std::vector<std::uint8_t>& rgba, const ivec2& size, double u, double v, int channel) {
  u = std::clamp(u - 0.5, 0.0, size.x - 1.0), v = std::clamp(v - 0.5, 0.0, size.y - 1.0);
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const auto at = [&](int px, int py) {
    return static_cast<double>(
        rgba[static_cast<std::size_t>(4 * (std::min(py, size.y - 1) * size.x + std::min(px, size.x - 1)) + channel)]);
  };
  const double a = u - left, b = v - top;
  return (1 - b) * ((1 - a) * at(left, top) + a * at(left + 1, top)) +
         b * ((1 - a) * at(left, top + 1) + a * at(left + 1, top + 1));
}

/// Composes a random picture into a target of this size. `place`: position in the picture for a position in the target,
/// both as fractions. Returns the largest difference from exact interpolation at these positions.
template <class Place>
double worst_level(const ivec2& target, unsigned seed, const Place& place, const Warp* warp = nullptr) {
  constexpr ivec2 kSize{64, 48};
  std::mt19937 random(seed);
  std::vector<std::uint8_t> eye(static_cast<std::size_t>(4 * kSize.x * kSize.y));
  for (std::uint8_t& byte : eye) byte = static_cast<std::uint8_t>(random());
  std::vector<std::uint8_t> out(static_cast<std::size_t>(4 * target.x * target.y));
  ProcessorComposer composer;
  composer.compose({{eye.data(), eye.data()}, kSize}, Mix::kOneEye, {{0, 0}, target}, warp ? 1 : 0,
                   {0, 0, target.x, target.y}, out.data(), static_cast<std::size_t>(4 * target.x), warp);
  double worst = 0;
  for (int y = 0; y < target.y; ++y)
    for (int x = 0; x < target.x; ++x)
      for (int channel = 0; channel < 3; ++channel) {
        // The eyes' pictures are RGBA, the target is BGRA.
        const std::uint8_t drawn = out[static_cast<std::size_t>(4 * (y * target.x + x) + 2 - channel)];
        const glm::dvec2 at = place(glm::dvec2((x + 0.5) / target.x, (y + 0.5) / target.y)) * glm::dvec2(kSize);
        worst = std::max(worst, std::abs(drawn - exact(eye, kSize, at.x, at.y, channel)));
      }
  return worst;
}

TEST(ProcessorComposer, AStretchedOrWarpedPictureDiffersFromExactInterpolationByAtMostTwoOf255Levels) {
  for (const ivec2& target : {ivec2{256, 192}, ivec2{160, 120}, ivec2{97, 201}, ivec2{20, 13}})
    EXPECT_LE(worst_level(target, 11, [](const glm::dvec2& at) { return at; }), 2) << target.x;
  // A warp that stretches the picture by 0.9 in x, and moves the picture by a tenth of its height.
  Warp warp;
  for (auto& places : warp)
    for (int row = 0; row < kWarpSide; ++row)
      for (int column = 0; column < kWarpSide; ++column)
        places.push_back({0.05f + 0.9f * static_cast<float>(column) / (kWarpSide - 1),
                          0.1f + static_cast<float>(row) / (kWarpSide - 1)});
  const auto moved = [](const glm::dvec2& at) { return glm::dvec2(0.05 + 0.9 * at.x, 0.1 + at.y); };
  EXPECT_LE(worst_level({97, 80}, 12, moved, &warp), 2);
}

}  // namespace
}  // namespace typodont::display

#include "engine/app/picture/detail.h"

#include <algorithm>

namespace typodont {

namespace {
// If the wanted and the current tolerance differ by more than this factor, the tooth is meshed again.
constexpr float kStep = 1.3f;
}  // namespace

double screen_pixel(const display::DisplayRig& rig) {
  const display::Screen& screen = rig.screen;
  return glm::length(screen.lower_right - screen.lower_left) /
         std::max(display::eye_pixels(screen.layout, screen.pixels).x, 1);
}

float surface_tolerance(double pixel, double voxel, const render::Quality& quality) {
  return static_cast<float>(std::clamp(quality.surface_error * pixel / voxel, 0.1, 0.6));
}

float surface_tolerance(const display::DisplayRig& rig, double voxel, const render::Quality& quality) {
  return surface_tolerance(screen_pixel(rig) / quality.scale, voxel, quality);
}

bool Detail::follow(double pixel, const render::Quality& quality) {
  if (pixel <= 0) return false;
  const float wanted = surface_tolerance(pixel, voxel_, quality);
  if (wanted < tolerance_ * kStep && wanted > tolerance_ / kStep) return false;
  tolerance_ = wanted;
  return true;
}

}  // namespace typodont

// Presses a round bur of 1.2 mm by 0.2 mm into a ball of enamel, first at rest, then rotating. Prints the force every
// 100 ms, and lines with name, found value and the value expected from the geometry.
#include <cstdio>

#include "haptics/lockstep.h"

using namespace typodont;

int main() {
  constexpr double kRadius = 3e-3, kVoxel = 0.1e-3, kDepth = 0.2e-3, kPi = 3.14159265358979;  // m
  constexpr int kEdge = 95;
  haptics::DenseTissue ball{.frame = {.origin = dvec3(-47 * kVoxel), .voxel = kVoxel}, .size = glm::ivec3(kEdge)};
  for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
    const glm::ivec3 voxel(i / (kEdge * kEdge), i / kEdge % kEdge, i % kEdge);
    const double distance = glm::length(ball.frame.to_world(voxel)) - kRadius;
    ball.distance.push_back(static_cast<float>(distance));
    ball.tissue.push_back(distance < kVoxel ? Tissue::kEnamel : Tissue::kAir);
  }

  haptics::ServoSettings settings;     // 1 kHz, 1 N/mm
  settings.spindle.free_speed = 30e3;  // rad/s
  haptics::LockStep core(haptics::TissueVolume(ball), settings);

  const double touch = kRadius + settings.tool.radius(), deepest = touch - kDepth;  // m, height of the bur's middle
  ServoTick tick;
  Cut cut;
  for (int i = 0; i < 3000; ++i) {
    const double z = std::max(deepest, touch + 0.5e-3 - i * 2e-6);  // m: at 2 mm/s, then held
    const haptics::HandSample hand{.t = i * Nanos(1000000), .X_WT = {.p = {0, 0, z}}, .pedal = i < 1000 ? 0.0 : 1.0};
    core.tick(hand, tick, cut);
    if (i % 100 == 99) std::printf("force_N %.6f\n", tick.f_T_W.z);
    if (i == 999) std::printf("pressed_N %.6f %.6f\n", tick.f_T_W.z, 1000 * kDepth);
  }
  // Ball and bur are held at the distance d. They have a lens in common.
  const double r = settings.tool.radius(), d = tick.X_WG.p.z, away = kRadius + r - d;
  const double lens =
      kPi * away * away * (d * d + 2 * d * (r + kRadius) - 3 * (kRadius - r) * (kRadius - r)) / (12 * d);
  std::printf("drilled_N %.6f %.6f\n", tick.f_T_W.z, 1000 * (d - deepest));
  std::printf("removed_mm3 %.6f %.6f\n", tick.removed[static_cast<std::size_t>(Tissue::kEnamel)] * 1e9, lens * 1e9);
}

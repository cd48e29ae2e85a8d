#include "engine/app/picture/mirror_fog.h"

#include <algorithm>
#include <cmath>

namespace typodont {

namespace {

/// True if the bur is in front of the glass, nearer than `reach` (m), so that its jet rinses the glass.
bool rinsed(const MouthMirror& mirror, const dvec3& p_WT, double reach) {
  const dvec3 from = inverse(mirror.X_WM) * p_WT;
  return from.z > 0 && from.z < reach && std::hypot(from.x, from.y) < 0.5 * mirror.diameter;
}

}  // namespace

void MirrorFog::advance(double dt, const MouthMirror& mirror, const MirrorAir& air) {
  const bool held = mirror.diameter > 0, warming = held && air.in_mouth;
  // How fast breath fogs the glass depends on the glass's temperature. The mean
  // temperature over the step is exact enough, because glass warms slowly.
  const double goal = warming ? 0 : 1, before = cold_;
  cold_ = goal + (cold_ - goal) * std::exp(-dt / law_.warm_time);
  double up = warming ? 0.5 * (before + cold_) / law_.breath_time : 0, down = 1 / law_.dry_time;
  if (held && air.water > 0) {
    const double away = glm::length(air.p_WT - mirror.X_WM.p) / law_.mist_reach;
    up += air.water / (law_.mist_time * (1 + away) * (1 + away));
    if (rinsed(mirror, air.p_WT, law_.rinse_reach)) down += air.water / law_.rinse_time;
  }
  // Solves d fog/dt = up (1 − fog) − down fog for constant rates (1/s).
  const double rate = up + down, balance = up / rate;
  fog_ = balance + (fog_ - balance) * std::exp(-rate * dt);
}

double MirrorFog::fog() const {
  return std::round(64 * fog_) / 64;
}

MirrorAir MirrorFog::air(const MouthMirror& mirror, const ServoTick& tick, bool spraying) const {
  // m; a mirror closer than this to the given point on the gum's edge counts as inside the patient's mouth
  constexpr double kMouth = 50e-3;
  return {.in_mouth = mouth_ && glm::length(mirror.X_WM.p - *mouth_) < kMouth,
          .water = spraying && tick.spindle != 0 ? std::clamp(tick.pedal, 0.0, 1.0) : 0,
          .p_WT = tick.X_WG.p};
}

std::optional<MirrorFog> mirror_fog_of(const Scene& scene) {
  std::optional<dvec3> mouth;
  if (scene.surroundings && scene.surroundings->mouth == Mouth::kPatient) mouth = scene.surroundings->margin;
  if (!mouth && !scene.spray) return std::nullopt;
  return MirrorFog(scene.mouth_mirror.fog, mouth);
}

}  // namespace typodont

// Breath condenses on cold glass, mist settles, air dries, a jet rinses. Any thread.
#pragma once

#include <optional>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/contract/mouth_mirror.h"

namespace typodont {

/// What fogs or clears the mirror.
struct MirrorAir {
  bool in_mouth = false;  // of a patient who breathes
  double water = 0;       // 0..1, of the spray's full flow
  dvec3 p_WT{0, 0, 0};    // m, W, of the bur's head, where the spray is aimed
};

struct MirrorFogLaw {
  double breath_time = 5;    // s, breath on cold glass
  double warm_time = 25;     // s, to the temperature of mouth or room
  double mist_time = 1;      // s, spray on a glass beside the bur
  double mist_reach = 8e-3;  // m from the bur, at a quarter of the mist's density
  double dry_time = 20;      // s, air
  double rinse_time = 0.15;  // s, jet of water
  /// m in front of the glass, within which a jet rinses
  double rinse_reach = 6e-3;
};

class MirrorFog {
 public:
  /// `fog`: at the start, 0..1. `mouth`: m, W; empty: nobody breathes.
  explicit MirrorFog(double fog = 0, const std::optional<dvec3>& mouth = {}, const MirrorFogLaw& law = {})
      : law_(law), mouth_(mouth), fog_(fog) {}
  /// At this tick. `spraying`: water is on.
  MirrorAir air(const MouthMirror& mirror, const ServoTick& tick, bool spraying) const;
  /// By `dt` s; one long step is nearly several short ones. Diameter 0: no mirror, and outside the mouth.
  void advance(double dt, const MouthMirror& mirror, const MirrorAir& air);
  /// 0 (clear) to 1, in steps of 1/64, so that slow changes do not redraw every frame.
  double fog() const;

 private:
  MirrorFogLaw law_;
  std::optional<dvec3> mouth_;
  double fog_ = 0;
  double cold_ = 1;  // of the glass: 1 room, 0 mouth
};

/// Empty without a mouth or spray: fog is then constant.
std::optional<MirrorFog> mirror_fog_of(const Scene& scene);

}  // namespace typodont

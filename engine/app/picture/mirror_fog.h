// Fog on the mouth mirror: breath condenses on the cold glass, the mist of the spray settles on it, air dries it, and a
// jet of water rinses it. Plain data and one class; any thread.
#pragma once

#include <optional>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/contract/mouth_mirror.h"

namespace typodont {

/// What fogs the mirror and clears it.
struct MirrorAir {
  bool in_mouth = false;  // the glass is in the mouth of a patient who breathes
  double water = 0;       // 0..1, fraction of the spray's flow
  dvec3 p_WT{0, 0, 0};    // m, W: the bur's head, at which the spray is aimed
};

struct MirrorFogLaw {
  double breath_time = 5;     // s in which breath fogs a cold glass
  double warm_time = 25;      // s in which the glass takes the temperature of the mouth, or of the room
  double mist_time = 1;       // s in which the spray fogs a glass at the bur
  double mist_reach = 8e-3;   // m, distance at which the mist is four times thinner
  double dry_time = 20;       // s in which air dries the glass
  double rinse_time = 0.15;   // s in which a jet rinses the glass
  double rinse_reach = 6e-3;  // m, largest distance of the bur's head in front of the glass that the jet rinses
};

class MirrorFog {
 public:
  /// `fog`: at the start, 0..1. `mouth`: m, W, a place in the mouth of a patient who breathes; empty: nobody breathes.
  explicit MirrorFog(double fog = 0, const std::optional<dvec3>& mouth = {}, const MirrorFogLaw& law = {})
      : law_(law), mouth_(mouth), fog_(fog) {}
  /// The air around a mirror at this tick. `spraying`: the water is switched on.
  MirrorAir air(const MouthMirror& mirror, const ServoTick& tick, bool spraying) const;
  /// Advances by dt seconds. The result does not depend on the length of the steps. Without a mirror (diameter 0) the
  /// glass is out of the mouth.
  void advance(double dt, const MouthMirror& mirror, const MirrorAir& air);
  /// 0: clear … 1: completely fogged; in steps of 1/64, so that a slow change does not redraw the glass in each
  /// frame.
  double fog() const;

 private:
  MirrorFogLaw law_;
  std::optional<dvec3> mouth_;
  double fog_ = 0;
  double cold_ = 1;  // 1: temperature of the room, 0: of the mouth
};

/// The fog of a scene's mirror. Empty if the scene has neither a patient's mouth nor a spray: its fog is constant.
std::optional<MirrorFog> mirror_fog_of(const Scene& scene);

}  // namespace typodont

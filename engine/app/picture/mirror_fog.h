// Fog on the mouth mirror. Breath condenses on the cold glass, the mist of the spray settles on it, air dries it, and a
// jet of water rinses it. Plain data and one class; for any thread.
#pragma once

#include <optional>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/contract/mouth_mirror.h"

namespace typodont {

/// The state of the mirror's surroundings that fogs or clears it.
struct MirrorAir {
  bool in_mouth = false;  // true: the glass is in the mouth of a patient who breathes
  double water = 0;       // 0..1, flow of the spray as a fraction of the full flow
  dvec3 p_WT{0, 0, 0};    // m, frame W: position of the bur's head, at which the spray is aimed
};

struct MirrorFogLaw {
  double breath_time = 5;    // s, time constant with which breath fogs a cold glass
  double warm_time = 25;     // s, time constant with which the glass takes the temperature of the mouth or of the room
  double mist_time = 1;      // s, time constant with which the spray fogs a glass beside the bur
  double mist_reach = 8e-3;  // m, distance from the bur at which the mist has a quarter of its density at the bur
  double dry_time = 20;      // s, time constant with which air dries the glass
  double rinse_time = 0.15;  // s, time constant with which a jet of water rinses the glass
  /// m, a jet rinses the glass if the bur's head is in front of the glass and nearer than this
  double rinse_reach = 6e-3;
};

class MirrorFog {
 public:
  /// `fog`: fog at the start, 0..1. `mouth`: m, frame W, a point in the mouth of a patient who breathes; empty: nobody
  /// breathes.
  explicit MirrorFog(double fog = 0, const std::optional<dvec3>& mouth = {}, const MirrorFogLaw& law = {})
      : law_(law), mouth_(mouth), fog_(fog) {}
  /// Describes the air around a mirror at this tick. `spraying`: true if the water is switched on.
  MirrorAir air(const MouthMirror& mirror, const ServoTick& tick, bool spraying) const;
  /// Advances the fog by `dt` seconds. One long step gives nearly the same result as several short steps. A mirror with
  /// diameter 0 is absent, and counts as outside the mouth.
  void advance(double dt, const MouthMirror& mirror, const MirrorAir& air);
  /// Returns the fog from 0 (clear) to 1 (opaque). It is rounded to 1/64, so that a slow change does not redraw the
  /// glass in each frame.
  double fog() const;

 private:
  MirrorFogLaw law_;
  std::optional<dvec3> mouth_;
  double fog_ = 0;
  double cold_ = 1;  // temperature of the glass: 1 as in the room, 0 as in the mouth
};

/// Returns the fog of a scene's mirror. Empty if the scene has neither a patient's mouth nor a spray, because the fog
/// is then constant.
std::optional<MirrorFog> mirror_fog_of(const Scene& scene);

}  // namespace typodont

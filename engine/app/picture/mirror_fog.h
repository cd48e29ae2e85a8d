// Fog on a mouth mirror: breath condenses on cold glass, spray settles on it, air dries it, a jet rinses it. Any
// thread.
#pragma once

#include <optional>

#include "engine/app/scene.h"
#include "engine/contract/contact.h"
#include "engine/contract/mouth_mirror.h"

namespace typodont {

/// Conditions that fog or clear the mirror.
struct MirrorAir {
  bool in_mouth = false;  // true: glass in the mouth of a breathing patient
  double water = 0;       // spray's current flow, as a fraction of its full flow
  dvec3 p_WT{0, 0, 0};    // m, frame W, position of the bur's head, at which the spray is aimed
};

struct MirrorFogLaw {
  double breath_time = 5;    // s, time constant: breath fogs cold glass
  double warm_time = 25;     // s, time constant: glass reaches the mouth's or room's temperature
  double mist_time = 1;      // s, time constant: spray fogs a glass beside the bur
  double mist_reach = 8e-3;  // m, distance from the bur at which the spray has a quarter of its density
  double dry_time = 20;      // s, time constant: air dries the glass
  double rinse_time = 0.15;  // s, time constant: a jet of water rinses the glass
  /// Distance in front of the glass up to which a jet rinses it, m.
  double rinse_reach = 6e-3;
};

class MirrorFog {
 public:
  /// `fog`: fog at the start, 0 to 1. `mouth`: position of the patient's mouth, m, frame W; empty: nobody breathes.
  explicit MirrorFog(double fog = 0, const std::optional<dvec3>& mouth = {}, const MirrorFogLaw& law = {})
      : law_(law), mouth_(mouth), fog_(fog) {}
  /// The conditions for the fog at this tick. `spraying`: the water is on.
  MirrorAir air(const MouthMirror& mirror, const ServoTick& tick, bool spraying) const;
  /// Advances the fog by `dt` (s). One long step gives nearly the same result as several short ones. If the mirror's
  /// diameter is 0, there is no mirror in the mouth.
  void advance(double dt, const MouthMirror& mirror, const MirrorAir& air);
  /// Current fog, 0 (clear) to 1, in steps of 1/64, so that slow changes do not redraw every frame.
  double fog() const;

 private:
  MirrorFogLaw law_;
  std::optional<dvec3> mouth_;
  double fog_ = 0;
  double cold_ = 1;  // temperature of the glass: 1 room, 0 mouth
};

/// Returns the fog of a scene's mirror; empty if there is neither a mouth nor spray, because the fog then never
/// changes.
std::optional<MirrorFog> mirror_fog_of(const Scene& scene);

}  // namespace typodont

// The god-object's step: as near to the hand as the contact planes allow, and which of them hold it there.
#pragma once

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/proxy/contact_set.h"

namespace typodont::haptics {

/// The normals of the planes that held the head in the last look: most likely their like do so in the next.
struct HeldBy {
  int count = 0;
  dvec3 n[3];
};
/// Sets `held` to the active planes' normals. In place: a copy would wait for its own stores.
void held_by(const ContactSet& set, const ActivePlanes& active, HeldBy& held) noexcept;
/// The planes of a new look that are most like those; a guess for nearest_allowed().
ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept;

/// The point nearest to `target` with n_i·(p - c) ≥ -(gap_i + overlap + slack yields_i) for all planes: the
/// god-object's step. Where no such point exists (a head wedged in its own slot), overlapping planes only keep it from
/// going deeper. `active` holds a guess of the answer's planes, of the same look, or none.
dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept;

}  // namespace typodont::haptics

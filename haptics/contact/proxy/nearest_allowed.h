// The step of the proxy: the position nearest to the hand that the contact planes allow, and the planes that hold the
// proxy there.
#pragma once

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/proxy/contact_set.h"

namespace typodont::haptics {

/// Normals of the planes that held the head in the last search. Similar planes probably hold the head in the next
/// search.
struct HeldBy {
  int count = 0;
  dvec3 n[3];
};
/// Sets `held` to the active planes' normals. Works in place, because a copy would wait for its own stores.
void held_by(const ContactSet& set, const ActivePlanes& active, HeldBy& held) noexcept;
/// Selects the planes of a new search that are most similar to `before`: a guess for nearest_allowed().
ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept;

/// Computes the point p nearest to `target` with n_i·(p - c) ≥ -(gap_i + overlap + slack yields_i) for all planes. If
/// no such point exists (a head wedged in its own slot), planes that the head overlaps only prevent deeper overlap.
/// `active`: on entry a guess of the active planes of the same search, or none; on return the active planes.
dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept;

}  // namespace typodont::haptics

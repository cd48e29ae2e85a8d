// Computes the step of the proxy: the position nearest to the hand that the contact planes allow, and the planes that
// hold the proxy there.
#pragma once

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/proxy/contact_set.h"

namespace typodont::haptics {

/// Normals of the planes that held the head in the last search. They are used to guess the active planes of the next
/// search.
struct HeldBy {
  int count = 0;
  dvec3 n[3];
};
/// Copies the normals of the active planes to `held`. The function writes directly to `held`, because a returned copy
/// of the struct would cost additional time (store forwarding).
void held_by(const ContactSet& set, const ActivePlanes& active, HeldBy& held) noexcept;
/// Guesses the active planes of a new search: selects the planes whose normals are most similar to those in `before`.
/// The result is the initial guess for nearest_allowed().
ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept;

/// Computes the position p of the head's centre nearest to `target` that the contact planes allow: n_i·(p - c) ≥
/// -(gap_i + overlap + slack · yields_i) for all planes i. c: present centre; `overlap`: allowed overlap; `slack`:
/// depth of a cut; all lengths in voxels. There may be no such position, for example in a narrow slot that the head has
/// cut. Then each plane that the head already overlaps only prevents a deeper overlap. `active`: on entry, a guess of
/// the planes that block the head, or none; on return, these planes.
dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept;

}  // namespace typodont::haptics

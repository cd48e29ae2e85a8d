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
/// Copies the normals of the active planes to `held`. (Returning a struct would be slower: failed store forwarding.)
void held_by(const ContactSet& set, const ActivePlanes& active, HeldBy& held) noexcept;
/// Guesses the active planes of a new search: selects the planes whose normals are most similar to those in `before`.
/// The result is the initial guess for nearest_allowed().
ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept;

/// Returns the position p nearest to `target` with n_i·(p - c) ≥ -(gap_i + overlap + allowed_depth · yields_i) for all
/// planes i in `set` (see ContactPlane), in voxels. If there is none, planes that the head overlaps only prevent a
/// deeper overlap. `active`: input: a guess of the planes that stop the head; output: these planes.
dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double allowed_depth, const dvec3& target,
                      ActivePlanes& active) noexcept;

}  // namespace typodont::haptics

// Entry into a bed by the four criteria of Zhao 2020. Pure.
#pragma once

namespace typodont::haptics::implant {

struct BedCriteria {
  bool at_centre = false;  // 1: tip at the centre of the entry
  // 2: as wide as the bed or slightly narrower, or a drill that may widen it
  bool fits = false;
  bool aligned = false;  // 3: aligned with the axis
  bool pushed = false;   // 4: axial force above Parameters::enter_force
};

enum class BedDecision { kStayFree, kEnterBed, kBeginBed };

/// `can_begin`: can drill this bone, touching with the tip; pushed (4) without the others, it starts a new bed.
constexpr BedDecision decide(const BedCriteria& c, bool can_begin) noexcept {
  if (!c.pushed) return BedDecision::kStayFree;
  if (c.at_centre && c.fits && c.aligned) return BedDecision::kEnterBed;
  return can_begin ? BedDecision::kBeginBed : BedDecision::kStayFree;
}

}  // namespace typodont::haptics::implant

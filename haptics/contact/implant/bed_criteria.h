// Decides when a tool enters an implant bed: the four criteria of Zhao 2020, as a pure function.
#pragma once

namespace typodont::haptics::implant {

struct BedCriteria {
  bool at_centre = false;  // (1) the tip is at the centre of the bed's surface
  bool fits = false;  // (2) the tool is as wide as the bed or slightly narrower, or it is a drill that widens the bed
  bool aligned = false;  // (3) the tool's axis is aligned with the bed's axis
  bool pushed = false;   // (4) the force along the axis exceeds the threshold
};

enum class BedDecision { kStayFree, kEnterBed, kBeginBed };

/// `can_begin`: the tool can drill this bone and touches it with its tip. If only (4) holds, such a tool begins a new
/// bed.
constexpr BedDecision decide(const BedCriteria& c, bool can_begin) noexcept {
  if (!c.pushed) return BedDecision::kStayFree;
  if (c.at_centre && c.fits && c.aligned) return BedDecision::kEnterBed;
  return can_begin ? BedDecision::kBeginBed : BedDecision::kStayFree;
}

}  // namespace typodont::haptics::implant

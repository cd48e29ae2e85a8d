// Decides whether a tool enters an implant bed, by the four criteria of Zhao 2020. The decision is a pure function.
#pragma once

namespace typodont::haptics::implant {

struct BedCriteria {
  bool at_centre = false;  // (1) the tip is at the centre of the bed's surface
  // (2) the tool's radius is equal to or slightly smaller than the bed's, or the tool is a drill that may widen the bed
  bool fits = false;
  bool aligned = false;  // (3) the tool's axis is aligned with the bed's axis
  bool pushed = false;   // (4) the force along the axis exceeds the threshold
};

enum class BedDecision { kStayFree, kEnterBed, kBeginBed };

/// `can_begin`: the tool can drill this bone and touches it with its tip. If criterion (4) is met, but another
/// criterion is not, such a tool starts a new bed.
constexpr BedDecision decide(const BedCriteria& c, bool can_begin) noexcept {
  if (!c.pushed) return BedDecision::kStayFree;
  if (c.at_centre && c.fits && c.aligned) return BedDecision::kEnterBed;
  return can_begin ? BedDecision::kBeginBed : BedDecision::kStayFree;
}

}  // namespace typodont::haptics::implant

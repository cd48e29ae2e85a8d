// Decides whether a tool enters an implant bed, by the four criteria of Zhao 2020. Pure functions.
#pragma once

namespace typodont::haptics::implant {

struct BedCriteria {
  bool at_centre = false;  // criterion 1: the tool's tip is at the centre of the bed's entry
  // criterion 2: the tool's radius is equal to or slightly smaller than the bed's, or the tool is a drill that may
  // widen the bed
  bool fits = false;
  bool aligned = false;  // criterion 3: the tool's axis is aligned with the bed's axis
  bool pushed = false;   // criterion 4: the force along the tool's axis exceeds the threshold Parameters::enter_force
};

enum class BedDecision { kStayFree, kEnterBed, kBeginBed };

/// Returns the decision from the four criteria. `can_begin`: the tool can drill this bone and touches it with its tip.
/// If such a tool is pushed (criterion 4) but does not meet all other criteria, it starts a new bed.
constexpr BedDecision decide(const BedCriteria& c, bool can_begin) noexcept {
  if (!c.pushed) return BedDecision::kStayFree;
  if (c.at_centre && c.fits && c.aligned) return BedDecision::kEnterBed;
  return can_begin ? BedDecision::kBeginBed : BedDecision::kStayFree;
}

}  // namespace typodont::haptics::implant

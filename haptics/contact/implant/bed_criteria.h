// Criteria for entering an implant bed (the drilled hole), after Zhao 2020.
#pragma once

namespace typodont::haptics::implant {

struct BedCriteria {
  bool at_centre = false;  // criterion 1: the tip is at the centre of the entry
  // criterion 2: the tool is as wide as the bed or slightly narrower, or is a drill that may widen it
  bool fits = false;
  bool aligned = false;  // criterion 3: the tool is aligned with the bed's axis
  bool pushed = false;   // criterion 4: the axial force is above Parameters::enter_force
};

enum class BedDecision { kStayFree, kEnterBed, kBeginBed };

/// `can_begin`: the tool's tip touches bone that the tool can drill. If `can_begin` is true and only
/// criterion 4 (pushed) is met, the tool begins a new bed.
constexpr BedDecision decide(const BedCriteria& c, bool can_begin) noexcept {
  if (!c.pushed) return BedDecision::kStayFree;
  if (c.at_centre && c.fits && c.aligned) return BedDecision::kEnterBed;
  return can_begin ? BedDecision::kBeginBed : BedDecision::kStayFree;
}

}  // namespace typodont::haptics::implant

#include "engine/app/picture/magnify.h"

#include <cmath>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

display::DisplayRig magnified_for(const display::DisplayRig& rig, const haptics::TissueVolume& tissue) {
  if (rig.magnify == 1) return rig;
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const dvec3 top = tissue.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z));
  const dvec3 about = rig.magnify_about.value_or(top) / kMillimetre;
  // mm from the fixed point of the magnification; the warning states the distance from hand to seen tool at this place.
  constexpr double kOff = 5;
  log::warn(
      "the picture is {:g} times life-size: what is seen and what is felt coincide at ({:.1f}, {:.1f}, {:.1f}) mm "
      "alone; "
      "{:g} mm beside it the tool is seen {:.3g} mm from the hand, and moves {:g} times as far as the hand",
      rig.magnify, about.x, about.y, about.z, kOff, kOff * std::abs(rig.magnify - 1), rig.magnify);
  return display::magnified(rig, top);
}

}  // namespace typodont

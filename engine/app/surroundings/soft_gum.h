// The gum around the working tooth as soft surface, for the servo.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/surroundings/plan.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// Makes the soft surface, about 10 mm around the gum's edge. Equal plans give equal points. Null if the gum is rigid.
/// Throws Error.
std::shared_ptr<const haptics::SoftSurface> soft_gum(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont

// Gum around the working tooth for the servo.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/surroundings/plan.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// About 10 mm around the edge; equal plans, equal points. Null: not soft. Throws Error.
std::shared_ptr<const haptics::SoftSurface> soft_gum(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont

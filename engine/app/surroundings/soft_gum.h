// The gum around the working tooth as soft tissue, for the servo's computation of contact.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/surroundings/plan.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// Samples the gum within about 10 mm of its edge at the working tooth. Equal plans give equal points. Null if the
/// plan's gum is not soft. Throws Error if the volume cannot be read.
std::shared_ptr<const haptics::SoftSurface> soft_gum(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont

// What the shaders are told of a frame: eyes, lamp, shadow map, tool and the looks of the tissues, in their own layout.
#pragma once

#include <array>
#include <optional>

#include "engine/render/look.h"
#include "engine/render/passes/passes.h"

namespace typodont::render {

/// `drawn`: the pictures' size. `bounds`: of what casts shadows; none where there is no tissue.
shared::FrameData frame_data_of(const Frame& frame, const Quality& quality, const std::array<Look, kTissueCount>& looks,
                                const ToolBody& tool, const VkExtent2D& drawn,
                                const std::optional<SceneBounds>& bounds);

}  // namespace typodont::render

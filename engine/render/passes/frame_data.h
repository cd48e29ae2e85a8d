// Fills the shaders' uniform data of a frame: eyes, lamp, shadow map, tool and appearance of the tissues.
#pragma once

#include <array>
#include <optional>

#include "engine/render/look.h"
#include "engine/render/passes/passes.h"

namespace typodont::render {

/// Returns the uniform data. `drawn`: size of the pictures. `bounds`: bounds of all bodies that cast shadows; no value
/// without tissue.
shared::FrameData frame_data_of(const Frame& frame, const Quality& quality, const std::array<Look, kMatterCount>& looks,
                                const ToolBody& tool, const HandpieceBody& handpiece, const VkExtent2D& drawn,
                                const std::optional<SceneBounds>& bounds);

}  // namespace typodont::render

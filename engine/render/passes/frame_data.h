// Uniform data of a frame for the shaders: eyes, lamp, shadow map, tool, looks.
#pragma once

#include <array>
#include <optional>

#include "engine/render/look.h"
#include "engine/render/passes/passes.h"

namespace typodont::render {

/// `drawn`: size of the pictures, pixels. `bounds`: box of all bodies that cast shadows; empty without tissue.
shared::FrameData frame_data_of(const Frame& frame, const Quality& quality, const std::array<Look, kMatterCount>& looks,
                                const ToolBody& tool, const HandpieceBody& handpiece, const VkExtent2D& drawn,
                                const std::optional<SceneBounds>& bounds);

}  // namespace typodont::render

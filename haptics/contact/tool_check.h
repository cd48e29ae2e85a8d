// The tools that a contact model accepts.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tool.h"

namespace typodont::haptics {

/// Throws an Error that names the first filling tool; for a model whose tissue can only be removed.
void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model);

}  // namespace typodont::haptics

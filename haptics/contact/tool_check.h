// The tools that a contact model accepts.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tool.h"

namespace typodont::haptics {

/// For a model whose tissue can only be removed: throws an Error that names the first filling tool.
void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model);

}  // namespace typodont::haptics

// Which tools a contact model takes.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tool.h"

namespace typodont::haptics {

/// For a model whose tissue can only be taken away. Throws Error, which names the first tool that fills.
void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model);

}  // namespace typodont::haptics

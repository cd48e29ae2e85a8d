// Checks which tools a contact model accepts.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tool.h"

namespace typodont::haptics {

/// Names the first filling instrument, for models that only remove.
void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model);

}  // namespace typodont::haptics

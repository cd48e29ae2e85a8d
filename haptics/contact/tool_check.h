// Checks which tools a contact model accepts.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tool.h"

namespace typodont::haptics {

/// Throws an Error that names the first filling instrument; for models that can only remove tissue.
void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model);

}  // namespace typodont::haptics

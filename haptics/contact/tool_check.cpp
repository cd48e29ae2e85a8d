#include "haptics/contact/tool_check.h"

#include <fmt/format.h>

#include "engine/base/error.h"

namespace typodont::haptics {

void refuse_tools_that_fill(std::span<const Tool> tools, std::string_view model) {
  for (const Tool& tool : tools) {
    if (tool.fill == Tissue::kAir) continue;
    throw Error(tool.name, "model", fmt::format("{} with a tool that fills", model),
                "the model offset, or another tool");
  }
}

}  // namespace typodont::haptics

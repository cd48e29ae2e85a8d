// Set-up code calls this where it makes a model or a body: method_counts() tells of it.
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// So many models and bodies more of that method. Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

// For method_counts(), at set-up.
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

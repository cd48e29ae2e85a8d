// The counters that method_counts() reads. Set-up code that makes a model or a body calls count_method().
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// Adds to the counters of one method. Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

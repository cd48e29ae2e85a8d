// Counts models and bodies of each contact method, for method_counts().
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// Adds to the counts of the method `name`. Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

// Counts the models and bodies that the process has created, for method_counts(). Set-up code calls count_method() when
// it creates a model or a body.
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// Adds numbers of created models and bodies to the counters of one method. Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

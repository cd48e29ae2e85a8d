// Counts the contact models (servo thread) and tissue bodies (carver thread) that the process creates, for
// method_counts(). Set-up code calls count_method().
#pragma once

#include <cstdint>
#include <string_view>

namespace typodont::haptics {

/// Adds numbers of created models and bodies to the counters of one method. Any thread.
void count_method(std::string_view name, std::uint64_t models, std::uint64_t bodies);

}  // namespace typodont::haptics

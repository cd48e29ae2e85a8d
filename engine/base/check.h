// Checks of conditions that can be false only because of a programming error. (For mistakes of the user, use Error.) A
// failed check prints the source line and the condition, then ends the process. Before the process ends, a handler that
// the servo has installed sends zero force.
#pragma once

namespace typodont {

using CheckHandler = void (*)() noexcept;
/// Sets the function that a failed check calls before the process ends. Not thread-safe; call before the servo starts.
void set_check_handler(CheckHandler handler) noexcept;

[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace typodont

#define TYPODONT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::typodont::check_failed(#condition, __FILE__, __LINE__))

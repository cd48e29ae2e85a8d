// Checks of internal assumptions. A failed check is a programming error, never a user's mistake (for mistakes, use
// Error). A failed check prints the place and the condition, then ends the process. The servo installs a handler that
// first sends zero force.
#pragma once

namespace typodont {

using CheckHandler = void (*)() noexcept;
/// The handler is called before a failed check ends the process. Set-up time; not thread-safe.
void set_check_handler(CheckHandler handler) noexcept;

[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace typodont

#define TYPODONT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::typodont::check_failed(#condition, __FILE__, __LINE__))

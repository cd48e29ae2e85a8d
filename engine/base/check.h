// A broken assumption of ours, never a user's mistake (that is an Error). Prints where and what, then ends the process;
// the servo installs a handler that first sends zero force.
#pragma once

namespace typodont {

using CheckHandler = void (*)() noexcept;
/// Called before the process ends on a failed check. Set-up time; not thread-safe.
void set_check_handler(CheckHandler handler) noexcept;

[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace typodont

#define TYPODONT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::typodont::check_failed(#condition, __FILE__, __LINE__))

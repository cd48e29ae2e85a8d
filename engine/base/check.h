// Checks of conditions that only a programming error violates; for users' mistakes, see Error. A failure prints line
// and condition, sends zero force through the servo's handler, and ends the process.
#pragma once

namespace typodont {

using CheckHandler = void (*)() noexcept;
/// Sets the function that a failed check calls before the process ends. Not thread-safe: call it before the servo
/// starts.
void set_check_handler(CheckHandler handler) noexcept;

[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace typodont

#define TYPODONT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::typodont::check_failed(#condition, __FILE__, __LINE__))

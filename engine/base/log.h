// Messages for people, on standard error; results go to standard output. A message that cannot be written at once is
// dropped and counted, so no function throws or waits. Any thread.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <exception>
#include <string_view>

namespace typodont::log {

/// Writes the text unchanged. False: it was not written completely. Also for signal handlers.
bool raw(std::string_view text) noexcept;
void write(std::string_view level, std::string_view text) noexcept;
/// Number of messages dropped so far. The next message that can be written states this number.
std::uint64_t dropped() noexcept;

template <class... Args>
void line(std::string_view level, fmt::format_string<Args...> format, Args&&... args) noexcept {
  try {
    write(level, fmt::format(format, std::forward<Args>(args)...));
  } catch (const std::exception&) {  // out of memory
    write(level, "a message for which there is no memory");
  }
}
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) noexcept {
  line("", format, std::forward<Args>(args)...);
}
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) noexcept {
  line("warning: ", format, std::forward<Args>(args)...);
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) noexcept {
  line("error: ", format, std::forward<Args>(args)...);
}

}  // namespace typodont::log

// Prints messages for people on standard error. The results of a command are printed on standard output, not with these
// functions.
#pragma once

#include <fmt/format.h>

#include <string_view>

namespace typodont::log {

void write(std::string_view level, std::string_view text);

template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  write("", fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  write("warning: ", fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) {
  write("error: ", fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace typodont::log

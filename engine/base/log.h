// Messages for people, on standard error. Results go to standard output.
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

#include "engine/base/log.h"

#include <cstdio>

namespace typodont::log {

void write(std::string_view level, std::string_view text) {
  fmt::print(stderr, "{}{}\n", level, text);
}

}  // namespace typodont::log

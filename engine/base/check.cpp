#include "engine/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace typodont {

static CheckHandler g_handler = nullptr;

void set_check_handler(CheckHandler handler) noexcept {
  g_handler = handler;
}

void check_failed(const char* condition, const char* file, int line) noexcept {
  if (g_handler) g_handler();
  std::fprintf(stderr, "%s:%d: broken assumption: %s\n", file, line, condition);
  std::abort();
}

}  // namespace typodont

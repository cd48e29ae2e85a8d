#include "engine/base/check.h"

#include <cstdlib>

#include "engine/base/log.h"

namespace typodont {

static CheckHandler g_handler = nullptr;

void set_check_handler(CheckHandler handler) noexcept {
  g_handler = handler;
}

void check_failed(const char* condition, const char* file, int line) noexcept {
  if (g_handler) g_handler();
  log::error("{}:{}: broken assumption: {}", file, line, condition);
  std::abort();
}

}  // namespace typodont

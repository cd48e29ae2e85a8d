#include "engine/base/log.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <exception>
#include <string>

#include "engine/base/harmless.h"

namespace typodont::log {

namespace {

std::atomic<std::uint64_t> g_dropped{0}, g_dropped_unreported{0};

/// Bytes that a pipe with a free page, or a terminal that is not paused, accepts at once.
constexpr std::size_t kPiece = 1024;

}  // namespace

bool raw(std::string_view text) noexcept {
  while (!text.empty()) {
    pollfd standard_error{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&standard_error, 1, 0) != 1 || standard_error.revents != POLLOUT) return false;
    const ssize_t n = ::write(STDERR_FILENO, text.data(), std::min(text.size(), kPiece));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

void write(std::string_view level, std::string_view text) noexcept {
  try {
    const std::uint64_t before = g_dropped_unreported.exchange(0);
    std::string line = fmt::format("{}{}\n", level, text);
    make_harmless(line);
    if (before > 0) line.insert(0, fmt::format("warning: {} messages before this one could not be written\n", before));
    if (raw(line)) return;
    g_dropped_unreported += before;
  } catch (const std::exception&) {  // out of memory
  }
  ++g_dropped, ++g_dropped_unreported;
}

std::uint64_t dropped() noexcept {
  return g_dropped;
}

}  // namespace typodont::log

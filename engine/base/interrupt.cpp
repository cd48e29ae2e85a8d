#include "engine/base/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <string_view>

#include "engine/base/log.h"
#include "engine/base/partial_file.h"

namespace typodont {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

std::atomic<void (*)() noexcept> g_last_act{nullptr};

void end_on_signal(int) {
  end_now();
}

void set_handler(int signal, void (*handler)(int), struct sigaction& before) noexcept {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, nullptr, &before);
  const bool ignored = !(before.sa_flags & SA_SIGINFO) && before.sa_handler == SIG_IGN;
  if (signal == SIGHUP && ignored) return;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void end_cleanly_on_interrupt() {
  struct sigaction before {};
  for (const int signal : kSignals) set_handler(signal, end_on_signal, before);
}

InterruptHandler::InterruptHandler(void (*handler)(int)) noexcept {
  for (std::size_t i = 0; i < kSignals.size(); ++i) set_handler(kSignals[i], handler, before_[i]);
}

InterruptHandler::~InterruptHandler() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

void set_end_hook(void (*act)() noexcept) noexcept {
  g_last_act = act;
}

void end_now() noexcept {
  if (const auto act = g_last_act.load()) act();
  remove_partial_files();
  constexpr std::string_view kWords = "error: cancelled; nothing was left half written\n";
  log::raw(kWords);
  ::_exit(1);
}

}  // namespace typodont

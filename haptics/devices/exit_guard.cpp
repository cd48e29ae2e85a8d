#include <signal.h>
#include <time.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <mutex>

#include "engine/base/error.h"
#include "engine/base/interrupt.h"
#include "haptics/device_safety.h"

namespace typodont::haptics {

namespace {

constexpr std::size_t kMost = 8;
std::array<std::atomic<HapticDevice*>, kMost> guarded{};
static_assert(std::atomic<HapticDevice*>::is_always_lock_free, "read inside signal handlers");

// All signals that can end a process, except SIGKILL.
constexpr std::array kSignals{SIGINT,  SIGTERM,   SIGHUP,  SIGQUIT,   SIGSEGV, SIGBUS,  SIGFPE, SIGILL,
                              SIGABRT, SIGPIPE,   SIGALRM, SIGUSR1,   SIGUSR2, SIGTRAP, SIGSYS, SIGXCPU,
                              SIGXFSZ, SIGVTALRM, SIGPROF, SIGSTKFLT, SIGIO,   SIGPWR};
std::array<struct sigaction, kSignals.size()> actions_before{};
std::atomic<bool> forbidden{false};

/// Gives the signal handlers a separate stack, so that they also run after a stack overflow.
void keep_a_stack_for_handlers() {
  static std::array<std::byte, 64 * 1024> memory;
  stack_t now{};
  // If a sanitizer or debugger has already set a stack, keeps it.
  if (::sigaltstack(nullptr, &now) != 0 || !(now.ss_flags & SS_DISABLE)) return;
  const stack_t stack{memory.data(), 0, memory.size()};
  ::sigaltstack(&stack, nullptr);
}

void on_signal(int signal, siginfo_t* info, void* context) {
  release_all_devices();
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    if (kSignals[i] != signal) continue;
    const struct sigaction& old = actions_before[i];
    if (old.sa_flags & SA_SIGINFO) return old.sa_sigaction(signal, info, context);
    if (old.sa_handler != SIG_DFL) return old.sa_handler(signal);
    ::signal(signal, SIG_DFL);
    ::raise(signal);  // the program receives this signal when the handler returns
    return;
  }
}

}  // namespace

void install_exit_guard() {
  static std::once_flag once;
  std::call_once(once, [] {
    keep_a_stack_for_handlers();
    set_end_hook(release_all_devices);
    std::atexit(+[] { release_all_devices(); });
    std::at_quick_exit(+[] { release_all_devices(); });
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      struct sigaction action {};
      action.sa_sigaction = on_signal;
      action.sa_flags = SA_SIGINFO | SA_ONSTACK;
      ::sigemptyset(&action.sa_mask);
      ::sigaction(kSignals[i], nullptr, &actions_before[i]);
      // A signal that the program ignores does not end the program, so it keeps its setting.
      if (!(actions_before[i].sa_flags & SA_SIGINFO) && actions_before[i].sa_handler == SIG_IGN) continue;
      ::sigaction(kSignals[i], &action, nullptr);
    }
  });
}

void guard_device(HapticDevice& device) {
  for (auto& slot : guarded) {
    HapticDevice* empty = nullptr;
    if (slot.compare_exchange_strong(empty, &device)) return;
  }
  throw RunFailure("more than eight force-feedback devices at once");
}

void unguard_device(HapticDevice& device) noexcept {
  for (auto& slot : guarded) {
    HapticDevice* mine = &device;
    if (slot.compare_exchange_strong(mine, nullptr)) return;
  }
}

void release_all_devices() noexcept {
  forbidden.store(true);
  bool any = false;
  for (int round = 0; round < 2; ++round) {
    for (auto& slot : guarded) {
      HapticDevice* device = slot.load();
      if (!device) continue;
      device->release();
      any = true;
    }
    // Repeats zero force after a pause: a running servo may have sent a force after the first zero. By now the servo
    // has read `forbidden` and sends zero itself.
    const timespec pause{0, 2'000'000};
    if (any && round == 0) ::nanosleep(&pause, nullptr);
  }
}

bool forces_forbidden() noexcept {
  return forbidden.load();
}

}  // namespace typodont::haptics

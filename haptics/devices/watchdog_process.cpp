#include "haptics/devices/watchdog_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>

namespace typodont::haptics {

namespace {

struct Zero {
  // Bytes of the command for zero force; large enough for a frame to a WebSocket service.
  std::array<std::uint8_t, 320> bytes{};
  std::size_t size = 0;
};

Nanos monotonic() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return Nanos{t.tv_sec} * kNanosPerSecond + t.tv_nsec;
}

}  // namespace

WatchdogProcess::WatchdogProcess(int descriptor, std::span<const std::uint8_t> zero) {
  Zero command;
  if (descriptor < 0 || zero.size() > command.bytes.size()) return;
  std::copy(zero.begin(), zero.end(), command.bytes.begin());
  command.size = zero.size();
  void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;
  shared_ = new (memory) Shared;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  child_ = ::fork();
  if (child_ != 0) {
    ::close(ends[0]);
    alive_ = ends[1];
    return;
  }

  // Code of the child process. The parent may have several threads, so the child may only make system calls.
  ::setsid();  // Ctrl-C and Ctrl-Z on the parent's terminal then do not reach the child
  ::prctl(PR_SET_NAME, "typodont-watch");
  sigset_t all;
  ::sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, nullptr);
  // Closes all descriptors except those of device and pipe, so that no file of the parent stays open after its end.
  const int low = std::min(descriptor, ends[0]), high = std::max(descriptor, ends[0]);
  if (low > 0) ::close_range(0, static_cast<unsigned>(low - 1), 0);
  if (high > low + 1) ::close_range(static_cast<unsigned>(low + 1), static_cast<unsigned>(high - 1), 0);
  ::close_range(static_cast<unsigned>(high + 1), ~0u, 0);
  sched_param priority{};
  priority.sched_priority = 85;
  ::sched_setscheduler(0, SCHED_FIFO, &priority);  // has no effect if the permission is missing

  // Time of the parent's newest write when this process last sent zero force, ns; -1: not sent yet. Zero is sent again
  // only after a newer write.
  Nanos silent_since = -1;
  for (;;) {
    pollfd parent{ends[0], POLLIN, 0};
    const bool force = shared_->force_out.load(std::memory_order_acquire);
    const int ready = ::poll(&parent, 1, force ? 2 : 10);
    if (ready < 0 && errno == EINTR) continue;
    if (ready != 0) break;  // the parent process has ended or closed the device
    const Nanos last = shared_->last_write.load(std::memory_order_relaxed);
    if (!force || monotonic() - last < kSilence || last == silent_since) continue;
    silent_since = last;
    [[maybe_unused]] const auto n = ::write(descriptor, command.bytes.data(), command.size);
  }
  // Sends zero force, also after a normal end of the parent, where it does no harm. Several times, because a full queue
  // may refuse the first write.
  for (int i = 0; i < 3; ++i) {
    if (::write(descriptor, command.bytes.data(), command.size) == static_cast<ssize_t>(command.size) && i > 0) break;
    const timespec pause{0, 1'000'000};
    ::nanosleep(&pause, nullptr);
  }
  ::_exit(0);
}

WatchdogProcess::~WatchdogProcess() {
  if (alive_ >= 0) ::close(alive_);
  if (child_ > 0) {
    while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  if (shared_) ::munmap(shared_, sizeof(Shared));
}

}  // namespace typodont::haptics

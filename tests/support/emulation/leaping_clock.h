// Lets the clocks of a program under test jump: the preloaded standin_clock.cpp reads the offsets from a file.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <new>
#include <string>

#include "engine/base/clock.h"

namespace typodont::test {

/// Offsets (ns) of the program's clocks from the machine's clocks.
struct ClockOffsets {
  std::atomic<std::int64_t> wall{0}, monotonic{0};
};

class LeapingClock {
 public:
  explicit LeapingClock(std::string file) : file_(std::move(file)) {
    const int fd = ::open(file_.c_str(), O_CREAT | O_RDWR | O_TRUNC, 0600);
    void* memory = fd >= 0 && ::ftruncate(fd, sizeof(ClockOffsets)) == 0
                       ? ::mmap(nullptr, sizeof(ClockOffsets), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0)
                       : MAP_FAILED;
    ::close(fd);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    offsets_ = new (memory) ClockOffsets;
  }
  ~LeapingClock() { ::munmap(offsets_, sizeof(ClockOffsets)); }
  LeapingClock(const LeapingClock&) = delete;
  LeapingClock& operator=(const LeapingClock&) = delete;

  /// Returns the environment variables that are written in front of the program in a shell command.
  std::string environment(const std::string& library) const {
    return "TYPODONT_CLOCK_FILE=" + file_ + " LD_PRELOAD=" + library;
  }
  /// Sets the difference (s) between the program's time of day and the true time of day.
  void set_wall(double s) { offsets_->wall = from_seconds(s); }
  /// Makes the monotonic clock and the time of day jump by `s` seconds.
  void leap(double s) { offsets_->monotonic += from_seconds(s), offsets_->wall += from_seconds(s); }

 private:
  std::string file_;
  ClockOffsets* offsets_ = nullptr;
};

}  // namespace typodont::test

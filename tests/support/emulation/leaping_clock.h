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

/// ns, offsets of the program's clocks from the machine's.
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

  /// Environment variables to put in front of the program in a shell command.
  std::string environment(const std::string& library) const {
    return "TYPODONT_CLOCK_FILE=" + file_ + " LD_PRELOAD=" + library;
  }
  /// Changes the time of day by s from the true one.
  void set_wall(double s) { offsets_->wall = from_seconds(s); }
  /// Makes the monotonic clock jump by s, and the time of day, too.
  void leap(double s) { offsets_->monotonic += from_seconds(s), offsets_->wall += from_seconds(s); }

 private:
  std::string file_;
  ClockOffsets* offsets_ = nullptr;
};

}  // namespace typodont::test

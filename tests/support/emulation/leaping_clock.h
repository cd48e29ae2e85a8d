// The clocks of a program under test, leaping when the test says so: standin_clock.cpp, preloaded, reads them from a
// file.
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

/// ns that the program's clocks differ from the machine's.
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

  /// What a shell puts before the program.
  std::string environment(const std::string& library) const {
    return "TYPODONT_CLOCK_FILE=" + file_ + " LD_PRELOAD=" + library;
  }
  /// Someone sets the time of day, s away from the truth.
  void set_wall(double s) { offsets_->wall = from_seconds(s); }
  /// The clock that everything is timed by leaps by s; time of day as well.
  void leap(double s) { offsets_->monotonic += from_seconds(s), offsets_->wall += from_seconds(s); }

 private:
  std::string file_;
  ClockOffsets* offsets_ = nullptr;
};

}  // namespace typodont::test

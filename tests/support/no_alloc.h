// A guard for tests of real-time loops: while it lives, any heap allocation or release by this thread is counted.
#pragma once

#include <cstddef>

namespace typodont::test {

/// { NoAlloc guard; servo.tick(); EXPECT_EQ(guard.count(), 0); }   (idea: Drake's LimitMalloc)
class NoAlloc {
 public:
  NoAlloc() noexcept;
  ~NoAlloc();
  NoAlloc(const NoAlloc&) = delete;
  NoAlloc& operator=(const NoAlloc&) = delete;
  /// Allocations and releases by this thread since construction.
  std::size_t count() const noexcept;
};

}  // namespace typodont::test

// A guard for tests of real-time loops. It counts all heap allocations and releases of this thread during its lifetime.
#pragma once

#include <cstddef>

namespace typodont::test {

/// Use: { NoAlloc guard; servo.tick(); EXPECT_EQ(guard.count(), 0); }   (idea: Drake's LimitMalloc)
class NoAlloc {
 public:
  NoAlloc() noexcept;
  ~NoAlloc();
  NoAlloc(const NoAlloc&) = delete;
  NoAlloc& operator=(const NoAlloc&) = delete;
  /// Returns the number of allocations and releases by this thread since construction.
  std::size_t count() const noexcept;
};

}  // namespace typodont::test

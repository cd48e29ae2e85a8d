// Passes values in order from one thread to another. If the ring is full, new values are dropped and counted. Never
// blocks.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// One producer thread, one consumer thread. Uses Boost.Lockfree, because ThreadSanitizer understands its atomics. Only
/// the constructor allocates.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// Appends a value. False: the ring is full, and the value is counted as dropped. Producer thread.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// True if the next push() will succeed. Producer thread.
  bool has_room() const noexcept { return queue_.write_available() > 0; }
  /// Removes the oldest value and copies it. False: the ring is empty. Consumer thread.
  bool pop(T& value) noexcept { return queue_.pop(value); }
  /// Number of values that can be popped now. Consumer thread.
  std::size_t ready() const noexcept { return queue_.read_available(); }
  /// Number of values lost to a full ring. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

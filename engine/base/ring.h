// A queue that passes values from one thread to one other thread, in order. If the queue is full, new values are
// dropped and counted. No call ever blocks.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// A ring buffer for one producer thread and one consumer thread. It uses Boost.Lockfree, because ThreadSanitizer
/// understands its atomics. Only the constructor allocates memory.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// Appends a value. Returns false, and counts the value as lost, if the ring is full. Never allocates. Producer
  /// thread.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Returns true if the next push() will succeed. Producer thread.
  bool has_room() const noexcept { return queue_.write_available() > 0; }
  /// Removes the oldest value and copies it to `value`. Returns false if the ring is empty. Consumer thread.
  bool pop(T& value) noexcept { return queue_.pop(value); }
  /// Returns the number of values that can be popped now. Consumer thread.
  std::size_t ready() const noexcept { return queue_.read_available(); }
  /// Returns the number of values that were lost because the ring was full. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

// A queue from one thread to one other thread that keeps the order. If the queue is full, new values are dropped and
// counted. No call ever blocks.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// Single producer, single consumer, based on Boost.Lockfree, because ThreadSanitizer understands its atomics (unlike
/// bare fences). Allocates only in the constructor.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// For the producer thread: appends a value. Returns false if the ring is full; the loss is counted. Never
  /// allocates.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Producer thread: true if the next push() will succeed.
  bool has_room() const noexcept { return queue_.write_available() > 0; }
  /// For the consumer thread: removes the oldest value. Returns false if the ring is empty.
  bool pop(T& value) noexcept { return queue_.pop(value); }
  /// Consumer thread: number of values that can be popped now.
  std::size_t ready() const noexcept { return queue_.read_available(); }
  /// Any thread: number of values that were lost because the ring was full.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

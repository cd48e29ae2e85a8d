// Every value, in order, from one thread to one other. Full means counted, never blocking.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// Single producer, single consumer, over Boost.Lockfree (whose atomics ThreadSanitizer understands; queues built on
/// bare fences it does not). Memory is taken at construction only.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// Producer thread. False, and counted, when full. Never allocates.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Producer thread: the next push() finds room.
  bool has_room() const noexcept { return queue_.write_available() > 0; }
  /// Consumer thread.
  bool pop(T& value) noexcept { return queue_.pop(value); }
  /// Consumer thread: how many values are there to pop; more may come meanwhile.
  std::size_t ready() const noexcept { return queue_.read_available(); }
  /// Any thread: how many values found no room.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

// Every value, in order, from one thread to one other. Full means counted, never blocking.
#pragma once

#include <readerwriterqueue.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// Single producer, single consumer, over moodycamel::ReaderWriterQueue. Memory is taken at construction only.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// Producer thread. False, and counted, when full. Never allocates.
  bool push(const T& value) noexcept {
    if (queue_.try_enqueue(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Consumer thread.
  bool pop(T& value) noexcept { return queue_.try_dequeue(value); }
  /// Any thread: how many values found no room.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  moodycamel::ReaderWriterQueue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

// Values in order from one thread to another. Full: new ones are dropped and counted. Never blocks.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

namespace typodont {

/// One producer, one consumer. Boost.Lockfree, because ThreadSanitizer understands its atomics. Only the constructor
/// allocates.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  /// False, and counted, if full. Producer.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// The next push() will succeed. Producer.
  bool has_room() const noexcept { return queue_.write_available() > 0; }
  /// The oldest value. False: empty. Consumer.
  bool pop(T& value) noexcept { return queue_.pop(value); }
  /// That can be popped now. Consumer.
  std::size_t ready() const noexcept { return queue_.read_available(); }
  /// Lost because full. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace typodont

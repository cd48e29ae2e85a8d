// Passes the newest value from one thread to one other thread (triple buffer). No thread ever waits, and no thread
// reads a partially written value. The writer is wait-free. The reader is lock-free: it retries if the writer has just
// published a value. A new value overwrites one that the reader has not fetched. Use ring.h if the reader needs every
// value.
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>

namespace typodont {

/// A channel with one writer thread and one reader thread. The writer changes the value (of type T) in place, so a
/// large value, for example a copy of the tissue, is never copied as a whole. The reader owns the value that it has
/// fetched until its next fetch(), and may change it.
template <class T>
class Latest {
 public:
  Latest() = default;
  /// All three slots start as copies of `initial`. So memory in a T is allocated at set-up and not in the loop.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}
  /// Constructor for a type T that cannot be copied. Each of the three slots gets one result of `make`.
  template <std::invocable Make>
  explicit Latest(Make make) : slots_{make(), make(), make()} {}

  // The writer thread calls this function and the next ones. Returns the writer's slot: the writer fills this slot,
  // then publishes it.
  T& back() noexcept { return slots_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void publish(const T& value) noexcept {
    back() = value;
    publish();
  }

  /// If the reader has returned its slot by hand_back(), the writer can use this slot: it becomes back(). Otherwise
  /// does nothing.
  void take_returned() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kReturned) && middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) {
      back_ = there & kIndex;
    }
  }
  /// Takes back the value that was published last, so that the writer can change it in back(). Returns false if the
  /// reader has already fetched this value.
  bool take_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) || !middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) return false;
    back_ = there & kIndex;
    return true;
  }

  // Fetches the newest value. Returns true if a value was published since the last fetch. The reader thread calls this
  // function and the next ones.
  bool fetch() noexcept {
    // compare_exchange is necessary here. Between the load and the exchange, the writer may take back the new value
    // (take_back) and leave an old value. A plain exchange would fetch the old value. The compare_exchange fails in
    // this case, and the loop tests again.
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    while (there & kFresh) {
      if (middle_.compare_exchange_strong(there, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        front_ = there & kIndex;
        return true;
      }
    }
    return false;
  }
  /// Undoes the last fetch, so that the value can be fetched again. Returns false if the writer has published a newer
  /// value.
  bool give_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kFresh) || !middle_.compare_exchange_strong(there, static_cast<std::uint8_t>(front_ | kFresh),
                                                             std::memory_order_acq_rel)) {
      return false;
    }
    front_ = there & kIndex;
    return true;
  }
  /// Returns the reader's slot front() to the writer, which gets it by take_returned(). Afterwards front() is another
  /// slot, which contains an older value. Does nothing if the writer has published a new value since the last fetch.
  void hand_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) && middle_.compare_exchange_strong(there, static_cast<std::uint8_t>(front_ | kReturned),
                                                             std::memory_order_acq_rel)) {
      front_ = there & kIndex;
    }
  }
  T& front() noexcept { return slots_[front_]; }
  const T& front() const noexcept { return slots_[front_]; }

 private:
  // One of the three slots belongs neither to the writer nor to the reader. The byte middle_ contains the index of this
  // slot (kIndex), whether the slot contains a new value (kFresh), and whether the reader has returned the slot
  // (kReturned).
  static constexpr std::uint8_t kIndex = 3, kFresh = 4, kReturned = 8;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;
  alignas(64) std::uint8_t front_ = 2;
};

}  // namespace typodont

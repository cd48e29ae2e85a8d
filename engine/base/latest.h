// Passes the newest value from one thread to another (triple buffer). Nobody waits, and no partial value is visible:
// the writer is wait-free, the reader lock-free. A newer value overwrites an unread one; to get every value, see
// ring.h.
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>

namespace typodont {

/// One writer, one reader. The writer changes T in place, so large values are never copied. The reader may change the
/// fetched value until its next fetch().
template <class T>
class Latest {
 public:
  Latest() = default;
  /// Makes three copies of `initial` now, so that T allocates memory at set-up only.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}
  /// If T cannot be copied: calls `make` three times.
  template <std::invocable Make>
  explicit Latest(Make make) : slots_{make(), make(), make()} {}

  // The next five functions are for the writer thread. Returns the slot to fill before publish().
  T& back() noexcept { return slots_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void publish(const T& value) noexcept {
    back() = value;
    publish();
  }

  /// If the reader has returned a slot by hand_back(), that slot becomes back().
  void take_returned() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kReturned) && middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) {
      back_ = there & kIndex;
    }
  }
  /// Makes the slot of the last published value back() again. False: the reader has already fetched this value.
  bool take_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) || !middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) return false;
    back_ = there & kIndex;
    return true;
  }

  // The following functions are for the reader thread. True: a value was published since the last fetch.
  bool fetch() noexcept {
    // Between load and exchange, the writer may call take_back(), which leaves an old value in middle_. An
    // unconditional exchange would fetch the old value; compare_exchange fails instead, and the loop tests again.
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    while (there & kFresh) {
      if (middle_.compare_exchange_strong(there, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        front_ = there & kIndex;
        return true;
      }
    }
    return false;
  }
  /// Undoes the last fetch(). False: a newer value was published.
  bool give_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kFresh) || !middle_.compare_exchange_strong(there, static_cast<std::uint8_t>(front_ | kFresh),
                                                             std::memory_order_acq_rel)) {
      return false;
    }
    front_ = there & kIndex;
    return true;
  }
  /// Gives front() to the writer (see take_returned()); front() becomes another slot with an older value. Does nothing
  /// if a new value was published.
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
  // Bits of middle_. kIndex: index of the slot that no thread uses. kFresh: unread value. kReturned: see hand_back().
  static constexpr std::uint8_t kIndex = 3, kFresh = 4, kReturned = 8;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;
  alignas(64) std::uint8_t front_ = 2;
};

}  // namespace typodont

// The newest value from one thread to another (triple buffer). Nobody waits or sees a partial value: the writer is
// wait-free; the reader lock-free, retrying after a publication. Unfetched values are overwritten; for every value, see
// ring.h.
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>

namespace typodont {

/// One writer, one reader. The writer changes T in place, so large values are never copied. The reader may change what
/// it has fetched until its next fetch().
template <class T>
class Latest {
 public:
  Latest() = default;
  /// Three copies of `initial`, so T allocates at set-up.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}
  /// For a T without copies: `make` three times.
  template <std::invocable Make>
  explicit Latest(Make make) : slots_{make(), make(), make()} {}

  // Writer's, as the next ones. The slot to fill, then publish.
  T& back() noexcept { return slots_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void publish(const T& value) noexcept {
    back() = value;
    publish();
  }

  /// A slot of hand_back(), if any, becomes back().
  void take_returned() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kReturned) && middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) {
      back_ = there & kIndex;
    }
  }
  /// The last published value returns to back(). False: already fetched.
  bool take_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) || !middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) return false;
    back_ = there & kIndex;
    return true;
  }

  // Reader's, as the next ones. True: published since the last fetch.
  bool fetch() noexcept {
    // Between load and exchange the writer may take back the new value and leave an old one. A plain exchange would
    // fetch that; this fails and tests again.
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    while (there & kFresh) {
      if (middle_.compare_exchange_strong(there, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        front_ = there & kIndex;
        return true;
      }
    }
    return false;
  }
  /// Undoes the last fetch. False: a newer value is there.
  bool give_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kFresh) || !middle_.compare_exchange_strong(there, static_cast<std::uint8_t>(front_ | kFresh),
                                                             std::memory_order_acq_rel)) {
      return false;
    }
    front_ = there & kIndex;
    return true;
  }
  /// front() goes to the writer (take_returned()) and becomes another slot with an older value. Nothing happens if a
  /// new value was published since.
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
  // Middle slot, of neither thread: index, with a new value, returned by the reader.
  static constexpr std::uint8_t kIndex = 3, kFresh = 4, kReturned = 8;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;
  alignas(64) std::uint8_t front_ = 2;
};

}  // namespace typodont

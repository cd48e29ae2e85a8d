// The newest value, from one thread to one other (triple buffer). Nobody ever waits, nobody ever sees half a value:
// wait-free on the writer's side, lock-free on the reader's, who looks again when the writer has just published. Values
// that the reader never looked at are overwritten; use ring.h where each one counts.
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>

namespace typodont {

/// One writer thread, one reader thread. T is written in place, so large values (a surface patch) cross without a copy,
/// and the reader owns what it fetched, and may change it, until its next fetch().
template <class T>
class Latest {
 public:
  Latest() = default;
  /// Every slot starts as a copy of `initial`, so that buffers inside T are sized at set-up, not in the loop.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}
  /// The same where T cannot be copied: every slot is what `make` returns.
  template <std::invocable Make>
  explicit Latest(Make make) : slots_{make(), make(), make()} {}

  // Writer thread.
  T& back() noexcept { return slots_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void publish(const T& value) noexcept {
    back() = value;
    publish();
  }

  /// Takes what was published back into back(), to change it, unless the reader has fetched it meanwhile: then false.
  bool take_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) || !middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) return false;
    back_ = there & kIndex;
    return true;
  }

  // Reader thread.
  /// Takes the newest value if there is one; true when it changed since the last fetch.
  bool fetch() noexcept {
    // Not a plain exchange: after this look the writer may take back what was seen, and leave an old value there. Each
    // further turn means that the writer has published meanwhile.
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    while (there & kFresh) {
      if (middle_.compare_exchange_strong(there, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        front_ = there & kIndex;
        return true;
      }
    }
    return false;
  }
  /// Puts what was fetched back as if it had not been, unless there is something newer: then false.
  bool give_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if ((there & kFresh) || !middle_.compare_exchange_strong(there, static_cast<std::uint8_t>(front_ | kFresh),
                                                             std::memory_order_acq_rel)) {
      return false;
    }
    front_ = there;
    return true;
  }
  T& front() noexcept { return slots_[front_]; }
  const T& front() const noexcept { return slots_[front_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;
  alignas(64) std::uint8_t front_ = 2;
};

}  // namespace typodont

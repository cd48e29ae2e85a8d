// Passes the newest value from one thread to one other thread (triple buffer). No thread ever waits, and no thread
// reads a partially written value. The writer is wait-free. The reader is lock-free and retries if the writer has just
// published. A value that the reader did not fetch in time is overwritten; use ring.h if every value counts.
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>

namespace typodont {

/// One writer thread, one reader thread. The writer fills T in place, so that large values (a surface patch) are never
/// copied. The reader owns the fetched value, and may change it, until its next fetch().
template <class T>
class Latest {
 public:
  Latest() = default;
  /// Every slot starts as a copy of `initial`, so that buffers inside T are allocated at set-up, not in the loop.
  explicit Latest(const T& initial) : slots_{initial, initial, initial} {}
  /// Constructor for a T that cannot be copied: every slot is a result of `make`.
  template <std::invocable Make>
  explicit Latest(Make make) : slots_{make(), make(), make()} {}

  // Functions for the writer thread. back(): the value to fill before it is published.
  T& back() noexcept { return slots_[back_]; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  void publish(const T& value) noexcept {
    back() = value;
    publish();
  }

  /// Moves the published value back into back(), so that the writer can change it. Returns false if the reader has
  /// already fetched it.
  bool take_back() noexcept {
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    if (!(there & kFresh) || !middle_.compare_exchange_strong(there, back_, std::memory_order_acq_rel)) return false;
    back_ = there & kIndex;
    return true;
  }

  // Functions for the reader thread.
  /// Fetches the newest value. Returns true if the value was published after the last fetch.
  bool fetch() noexcept {
    // A plain exchange would be wrong: after this load the writer may take back the fresh value and leave an old one in
    // the slot. The loop repeats only if the writer published after the load.
    std::uint8_t there = middle_.load(std::memory_order_relaxed);
    while (there & kFresh) {
      if (middle_.compare_exchange_strong(there, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        front_ = there & kIndex;
        return true;
      }
    }
    return false;
  }
  /// Puts the fetched value back as if it had not been fetched. Returns false if the writer has published a newer
  /// value.
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

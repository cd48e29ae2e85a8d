// Passes events from one thread to any number of threads, in order. The writer never waits and writes each event once.
// Each reader has its own place in the event log. If the writer overtakes a reader, the reader skips the overwritten
// events and counts them.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "engine/base/check.h"

namespace typodont {

/// A fixed array of slots and the number of events written so far. Event n is in slot n modulo the number of slots.
template <class T>
class EventLog {
  static_assert(std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>);

 public:
  /// `slots`: a power of two; readers can read the newest slots - 1 events. Only the constructor allocates memory.
  explicit EventLog(std::size_t slots) : mask_(slots - 1), words_(slots * kWords) {
    TYPODONT_CHECK(std::has_single_bit(slots));
  }

  /// Appends an event. Wait-free. Writer thread.
  void write(const T& event) noexcept {
    Words words{};
    std::memcpy(words.data(), &event, sizeof event);
    const std::uint64_t n = written_.load(std::memory_order_relaxed);
    std::atomic<std::uint64_t>* const slot = &words_[(n & mask_) * kWords];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
    written_.store(n + 1, std::memory_order_release);
  }
  /// Number of events written so far. Any thread.
  std::uint64_t written() const noexcept { return written_.load(std::memory_order_acquire); }

  /// A reader's place in the event log. Only one thread at a time may use it. The event log must outlive it.
  class Reader {
   public:
    /// Begins at the event log's first event.
    explicit Reader(const EventLog& event_log) : event_log_(&event_log) {}

    /// Copies the next event. False if there is none.
    bool next(T& event) noexcept {
      for (;;) {
        const std::uint64_t written = event_log_->written();
        if (next_ == written) return false;
        if (const std::uint64_t kept = event_log_->mask_; written - next_ > kept) {
          lost_ += written - kept - next_;
          next_ = written - kept;
        }
        if (event_log_->copy(next_, event)) return ++next_, true;
      }
    }
    /// Jumps to the newest event and copies it. The skipped events do not count as lost. False if there is no new
    /// event.
    bool newest(T& event) noexcept {
      const std::uint64_t before = next_;
      do {
        next_ = event_log_->written();
      } while (next_ != before && !event_log_->copy(next_ - 1, event));
      return next_ != before;
    }
    /// Number of events overwritten before this reader reached them.
    std::uint64_t lost() const noexcept { return lost_; }

   private:
    const EventLog* event_log_;
    std::uint64_t next_ = 0, lost_ = 0;
  };

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, kWords>;

  /// Copies event n. False if the writer may have begun to overwrite its slot. Sequence lock (Boehm 2012, "Can seqlocks
  /// get along with programming language memory models?") with atomic words instead of fences: a reader that reads a
  /// word of event n + slots also sees that `written_` is at least n + slots, so it refuses the copy.
  bool copy(std::uint64_t n, T& event) const noexcept {
    Words words;
    const std::atomic<std::uint64_t>* const slot = &words_[(n & mask_) * kWords];
    for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
    if (written_.load(std::memory_order_relaxed) - n > mask_) return false;
    std::memcpy(static_cast<void*>(&event), words.data(), sizeof event);
    return true;
  }

  const std::size_t mask_;  // number of slots - 1; also the number of events that readers can still read
  std::vector<std::atomic<std::uint64_t>> words_;
  alignas(64) std::atomic<std::uint64_t> written_{0};
};

}  // namespace typodont

// A handle is a number with the type of a pointer that nobody dereferences. A table contains the valid handles, so that
// a freed, forged or mixed-up handle gives an error, not a crash.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace typodont::bindings {

enum class Kind : std::uint8_t { kScene = 1, kHand, kCore, kServo, kSession, kSynth };

enum class Found { kHeld, kBadHandle, kBusy };

inline constexpr std::uint64_t kSlots = 4096;
inline constexpr int kKindBits = 4, kSlotBits = 12, kGenerationShift = kKindBits + kSlotBits;
static_assert(sizeof(void*) == 8, "a handle holds a kind, a place and a generation");

/// The generation increases whenever the slot is filled or emptied, so it is odd while the slot is filled. `state`:
/// twice the generation, plus one while a thread uses the object.
struct alignas(64) Slot {
  std::atomic<std::uint64_t> state{0};
  Kind kind{};
  void* object = nullptr;
};
extern std::array<Slot, kSlots> g_slots;

/// Locks a handle for this thread until the end of the scope. Any thread; never allocates. Inline, because every tick
/// calls it.
class HeldHandle {
 public:
  HeldHandle(const void* handle, Kind kind) noexcept {
    const auto value = reinterpret_cast<std::uintptr_t>(handle);
    const std::uint64_t generation = value >> kGenerationShift;
    if ((value & ((1u << kKindBits) - 1)) != static_cast<std::uint64_t>(kind) || generation % 2 == 0) return;
    Slot& slot = g_slots[value >> kKindBits & (kSlots - 1)];
    std::uint64_t state = generation << 1;
    if (!slot.state.compare_exchange_strong(state, state | 1, std::memory_order_acquire, std::memory_order_relaxed)) {
      if (state == (generation << 1 | 1)) found_ = Found::kBusy;
      return;
    }
    if (slot.kind != kind) {  // new_handle() never returned this handle
      slot.state.store(generation << 1, std::memory_order_release);
      return;
    }
    slot_ = &slot;
    state_ = generation << 1;
    found_ = Found::kHeld;
  }
  ~HeldHandle() {
    if (slot_) slot_->state.store(state_, std::memory_order_release);
  }
  HeldHandle(const HeldHandle&) = delete;
  HeldHandle& operator=(const HeldHandle&) = delete;

  Found found() const noexcept { return found_; }
  void* object() const noexcept { return slot_->object; }
  /// Makes the handle invalid; the caller now owns the object.
  void* drop() noexcept;

 private:
  Slot* slot_ = nullptr;  // null if the handle is not locked
  std::uint64_t state_ = 0;
  Found found_ = Found::kBadHandle;
};

/// Creates a handle. Null if 4096 handles exist. Any thread, but not during a tick.
void* new_handle(Kind kind, void* object);

}  // namespace typodont::bindings

#include "engine/bindings/c/handles.h"

#include <array>
#include <atomic>
#include <mutex>
#include <vector>

namespace typodont::bindings {

namespace {

constexpr std::uint64_t kSlots = 4096;
constexpr int kKindBits = 4, kSlotBits = 12, kGenerationShift = kKindBits + kSlotBits;
static_assert(sizeof(void*) == 8, "a handle holds a kind, a place and a generation");

/// A slot's state is twice its generation, plus one while a thread uses its object. Generations of living handles are
/// odd: each slot is filled and emptied in turn.
struct alignas(64) Slot {
  std::atomic<std::uint64_t> state{0};
  Kind kind{};
  void* object = nullptr;
};

std::array<Slot, kSlots> g_slots;
std::mutex g_mutex;                    // of what follows
std::vector<std::uint16_t> g_emptied;  // to be used again
std::uint64_t g_used = 0;              // slots ever filled

struct Parts {
  std::uint64_t generation, slot, kind;
};
Parts parts_of(const void* handle) noexcept {
  const auto value = reinterpret_cast<std::uintptr_t>(handle);
  return {value >> kGenerationShift, value >> kKindBits & (kSlots - 1), value & ((1u << kKindBits) - 1)};
}

}  // namespace

Found take(const void* handle, Kind kind, void*& object) noexcept {
  const Parts parts = parts_of(handle);
  if (parts.kind != static_cast<std::uint64_t>(kind) || parts.generation % 2 == 0) return Found::kBadHandle;
  Slot& slot = g_slots[parts.slot];
  std::uint64_t state = parts.generation << 1;
  if (!slot.state.compare_exchange_strong(state, state | 1, std::memory_order_acquire, std::memory_order_relaxed))
    return state == (parts.generation << 1 | 1) ? Found::kBusy : Found::kBadHandle;
  if (slot.kind != kind) {  // a handle that nobody was given
    slot.state.store(parts.generation << 1, std::memory_order_release);
    return Found::kBadHandle;
  }
  object = slot.object;
  return Found::kHeld;
}

void put_back(const void* handle) noexcept {
  const Parts parts = parts_of(handle);
  g_slots[parts.slot].state.store(parts.generation << 1, std::memory_order_release);
}

void* new_handle(Kind kind, void* object) {
  const std::lock_guard lock(g_mutex);
  if (g_emptied.empty() && g_used == kSlots) return nullptr;
  g_emptied.reserve(kSlots);  // so that drop() never allocates
  std::uint64_t place = g_used;
  if (g_emptied.empty()) {
    ++g_used;
  } else {
    place = g_emptied.back();
    g_emptied.pop_back();
  }
  Slot& slot = g_slots[place];
  const std::uint64_t generation = (slot.state.load(std::memory_order_relaxed) >> 1) + 1;
  slot.kind = kind;
  slot.object = object;
  slot.state.store(generation << 1, std::memory_order_release);
  return reinterpret_cast<void*>(generation << kGenerationShift | place << kKindBits |
                                 static_cast<std::uint64_t>(kind));
}

void drop(const void* handle) noexcept {
  const Parts parts = parts_of(handle);
  const std::lock_guard lock(g_mutex);
  Slot& slot = g_slots[parts.slot];
  slot.object = nullptr;
  slot.state.store((parts.generation + 1) << 1, std::memory_order_release);
  g_emptied.push_back(static_cast<std::uint16_t>(parts.slot));
}

}  // namespace typodont::bindings

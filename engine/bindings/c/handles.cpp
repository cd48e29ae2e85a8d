#include "engine/bindings/c/handles.h"

#include <mutex>
#include <utility>
#include <vector>

namespace typodont::bindings {

std::array<Slot, kSlots> g_slots;

namespace {

std::mutex g_mutex;                    // protects g_emptied and g_used
std::vector<std::uint16_t> g_emptied;  // indices of empty slots that can be reused
std::uint64_t g_used = 0;              // number of slots that were ever used

}  // namespace

void* new_handle(Kind kind, void* object) {
  const std::lock_guard lock(g_mutex);
  if (g_emptied.empty() && g_used == kSlots) return nullptr;
  g_emptied.reserve(kSlots);  // reserves memory now, because drop() must not allocate
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

void* HeldHandle::drop() noexcept {
  const std::lock_guard lock(g_mutex);
  Slot& slot = *std::exchange(slot_, nullptr);
  void* const object = std::exchange(slot.object, nullptr);
  // Increases the slot's generation and unlocks the slot. An even generation means that the slot is empty.
  slot.state.store(state_ + 2, std::memory_order_release);
  g_emptied.push_back(static_cast<std::uint16_t>(&slot - g_slots.data()));
  return object;
}

}  // namespace typodont::bindings
